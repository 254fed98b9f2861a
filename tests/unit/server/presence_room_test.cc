// What is told of the people in a scene, piece by piece, however many come and go meanwhile.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "render/scene/field_error.h"
#include "server/session/presence.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

// More than a room remembers.
constexpr int kManyDepartures = 1'100;

v1::Presence Named(const std::string& name) {
  v1::Presence presence;
  presence.set_display_name(name);
  return presence;
}

class PresenceRoomTest : public ::testing::Test {
 protected:
  std::string Join(const std::string& name) { return room_->Join({}, Named(name)); }
  std::vector<std::string> JoinMany(int count) {
    std::vector<std::string> ids;
    for (int i = 0; i < count; ++i) ids.push_back(Join("guest " + std::to_string(i)));
    return ids;
  }
  void ComeAndGo(int count) {
    for (int i = 0; i < count; ++i) room_->Leave(Join("passer-by"));
  }
  v1::PresenceUpdate Next(PresenceCursor& told) {
    v1::PresenceUpdate update;
    EXPECT_TRUE(room_->ChangesSince(told, me_, update));
    return update;
  }

  PresenceTable table_;
  const std::shared_ptr<PresenceRoom> room_ = table_.RoomOf("a scene");
  const std::string me_ = Join("me");
};

// The oldest reports are older than the oldest departure that is remembered.
TEST_F(PresenceRoomTest, ANewcomerIsToldOfEverybodyOnceAndThenThereIsNoMore) {
  const auto ids = JoinMany(70);
  ComeAndGo(kManyDepartures);
  PresenceCursor told;
  std::multiset<std::string> listed;
  int updates = 0;
  for (; room_->HasMore(told) && updates < 10; ++updates) {
    const auto update = Next(told);
    EXPECT_EQ(update.is_everything(), updates == 0) << updates;
    EXPECT_LE(static_cast<size_t>(update.participants_size()), PresenceRoom::kMostPerUpdate);
    for (const auto& other : update.participants()) listed.insert(other.participant_id());
  }
  EXPECT_EQ(updates, 2) << "of 64 and of 6";
  EXPECT_EQ(listed, std::multiset<std::string>(ids.begin(), ids.end()));
  v1::PresenceUpdate nothing;
  EXPECT_FALSE(room_->ChangesSince(told, me_, nothing));
}

TEST_F(PresenceRoomTest, WhatChangesBetweenTwoPiecesIsTold) {
  const auto ids = JoinMany(70);
  ComeAndGo(kManyDepartures);
  PresenceCursor told;
  ASSERT_EQ(Next(told).participants_size(), 64);
  room_->Leave(ids[0]);   // who has been listed
  room_->Leave(ids[69]);  // who has not
  room_->Report(ids[1], Named("renamed"));
  v1::EditControl take;
  take.mutable_take();
  ASSERT_EQ(room_->Control(ids[2], take), absl::OkStatus());
  const auto update = Next(told);
  EXPECT_FALSE(update.is_everything());
  EXPECT_THAT(update.left(), UnorderedElementsAre(ids[0], ids[69]));
  ASSERT_EQ(update.participants_size(), 6);  // 64 to 68, and
  EXPECT_EQ(update.participants(5).participant_id(), ids[1]);
  EXPECT_EQ(update.participants(5).presence().display_name(), "renamed");
  EXPECT_EQ(update.editor_id(), ids[2]);
  EXPECT_FALSE(room_->HasMore(told));
  ASSERT_EQ(room_->Control(ids[2], take), absl::OkStatus());
  v1::PresenceUpdate nothing;
  EXPECT_FALSE(room_->ChangesSince(told, me_, nothing)) << "they have it already";
}

TEST_F(PresenceRoomTest, WhoeverMissedTooManyDeparturesIsToldEverythingAnew) {
  auto ids = JoinMany(3);
  PresenceCursor told;
  ASSERT_EQ(Next(told).participants_size(), 3);
  ComeAndGo(1'000);
  EXPECT_EQ(Next(told).left_size(), 1'000);
  room_->Leave(ids[0]);
  ComeAndGo(kManyDepartures);
  const auto update = Next(told);
  EXPECT_TRUE(update.is_everything());
  EXPECT_EQ(update.participants_size(), 2);
  EXPECT_EQ(update.left_size(), 0);
  EXPECT_FALSE(room_->HasMore(told));
}

TEST_F(PresenceRoomTest, RefusalsNameTheEditorOrSayThatThereIsNone) {
  const std::string ada = Join("Ada"), nameless = Join("");
  v1::EditControl take, release, hand_over;
  take.mutable_take();
  release.mutable_release()->set_keep_single_editor(true);
  hand_over.mutable_hand_over()->set_participant_id(me_);
  const auto text_of = [&](const v1::EditControl& control) {
    return std::string(room_->Control(me_, control).message());
  };
  for (const auto* control : {&release, &hand_over}) {
    EXPECT_EQ(text_of(*control), "edit_control: found nobody editing, need to be the one editor");
  }
  ASSERT_EQ(room_->Control(ada, take), absl::OkStatus());
  const std::string named = "Ada (" + ada + ") editing";
  for (const auto* control : {&take, &release, &hand_over}) {
    EXPECT_THAT(text_of(*control), HasSubstr("found " + named));
  }
  EXPECT_THAT(std::string(room_->CheckMayEdit("").message()), HasSubstr("found " + named))
      << "to whoever is not in the scene too";
  take.mutable_take()->set_from_other(true);
  ASSERT_EQ(room_->Control(nameless, take), absl::OkStatus());
  EXPECT_THAT(text_of(release), HasSubstr("found " + nameless + " editing"));
}

// Whoever comes back takes editing from the participant that they were, and may come too late.
TEST_F(PresenceRoomTest, EditingIsTakenFromTheOneWhoIsNamedAndFromNobodyElse) {
  const std::string ada = Join("Ada"), ada_again = Join("Ada"), bob = Join("Bob");
  v1::EditControl take, take_from_ada;
  take.mutable_take()->set_from_other(true);
  take_from_ada.mutable_take()->set_from_id(ada);
  ASSERT_EQ(room_->Control(ada, take), absl::OkStatus());
  ASSERT_EQ(room_->Control(bob, take), absl::OkStatus());
  for (const bool from_other : {false, true}) {
    take_from_ada.mutable_take()->set_from_other(from_other);
    const absl::Status refused = room_->Control(ada_again, take_from_ada);
    EXPECT_EQ(refused.code(), absl::StatusCode::kFailedPrecondition) << refused;
    EXPECT_EQ(ErrorReason(refused), "EDITOR_PRESENT");
    EXPECT_THAT(std::string(refused.message()), HasSubstr("found Bob (" + bob + ") editing"));
    EXPECT_EQ(room_->CheckMayEdit(bob), absl::OkStatus());
  }
  take_from_ada.mutable_take()->set_from_other(false);
  ASSERT_EQ(room_->Control(ada, take), absl::OkStatus());
  EXPECT_EQ(room_->Control(ada_again, take_from_ada), absl::OkStatus());
  EXPECT_EQ(room_->CheckMayEdit(ada_again), absl::OkStatus());
  EXPECT_EQ(ErrorReason(room_->CheckMayEdit(ada)), "NOT_EDITOR");
  EXPECT_EQ(room_->Control(ada_again, take_from_ada), absl::OkStatus()) << "it is theirs already";
  room_->Leave(ada_again);
  EXPECT_EQ(room_->Control(bob, take_from_ada), absl::OkStatus()) << "nobody has it";
  EXPECT_EQ(room_->CheckMayEdit(bob), absl::OkStatus());
}

TEST_F(PresenceRoomTest, AnUpdateFitsIntoAMessageWhateverPeopleSay) {
  constexpr size_t kEach = 100'000;
  for (int i = 0; i < 30; ++i) room_->Join({}, Named(std::string(kEach, 'a')));
  room_->Join({}, Named(std::string(2'000'000, 'b')));
  PresenceCursor told;
  int listed = 0;
  while (room_->HasMore(told)) {
    const auto update = Next(told);
    ASSERT_GT(update.participants_size(), 0);
    listed += update.participants_size();
    if (update.participants_size() > 1) {
      EXPECT_LT(update.ByteSizeLong(), 1u << 20);
    }
  }
  EXPECT_EQ(listed, 31);
}

}  // namespace
}  // namespace penumbra::testing
