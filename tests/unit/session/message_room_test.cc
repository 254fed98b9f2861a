#include "client/session/message_room.h"

#include <gtest/gtest.h>

namespace penumbra {
namespace {

TEST(MessageRoomTest, IsWhatEverythingElseLeaves) {
  EXPECT_EQ(RoomInMessage(size_t{1} << 20), (size_t{1} << 20) - 1024);
}

TEST(MessageRoomTest, IsThereWhereMessagesAreTooSmall) {
  EXPECT_EQ(RoomInMessage(0), 1024u);
  EXPECT_EQ(RoomInMessage(1024), 1024u);
}

}  // namespace
}  // namespace penumbra
