#include "client/session/session_presence.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>

namespace penumbra::testing {
namespace {

v1::PresenceUpdate EditedBy(const std::string& id) {
  v1::PresenceUpdate update;
  update.set_is_everything(true);
  update.add_participants()->set_participant_id("bob");
  update.set_single_editor(true);
  update.set_editor_id(id);
  return update;
}

// What is to be asked for by whoever edited as "first" when the connection was lost and has come
// back as "second", and is told that `editor` edits by now.
std::optional<v1::TakeEditing> ToRegainFrom(const std::string& editor) {
  SessionPresence mine(v1::Presence(), nullptr, [](const v1::Presence&) {});
  mine.Begin("first");
  EXPECT_TRUE(mine.Receive(EditedBy("first")).ok());
  mine.Lose();
  mine.Begin("second");
  EXPECT_FALSE(mine.EditingToRegain()) << "before it is known who edits";
  EXPECT_TRUE(mine.Receive(EditedBy(editor)).ok());
  return mine.EditingToRegain();
}

TEST(SessionPresenceTest, EditingIsTakenBackFromWhomOneWasAndFromNobodyElse) {
  const auto from_ghost = ToRegainFrom("first");
  ASSERT_TRUE(from_ghost);
  EXPECT_EQ(from_ghost->from_id(), "first");
  const auto from_nobody = ToRegainFrom("");
  ASSERT_TRUE(from_nobody);
  EXPECT_EQ(from_nobody->from_id(), "");
  EXPECT_FALSE(from_nobody->from_other());
  EXPECT_FALSE(ToRegainFrom("bob")) << "it is theirs";
  EXPECT_FALSE(ToRegainFrom("second")) << "it is back";
}

}  // namespace
}  // namespace penumbra::testing
