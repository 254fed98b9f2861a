#include "client/session/attendance_book.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace penumbra::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

v1::PresenceUpdate Everybody(const std::vector<std::string>& ids) {
  v1::PresenceUpdate update;
  update.set_is_everything(true);
  for (const std::string& id : ids) {
    update.add_participants()->set_participant_id(id);
    update.mutable_participants()->rbegin()->mutable_presence()->set_display_name("I am " + id);
  }
  return update;
}

v1::PresenceUpdate Edits(v1::PresenceUpdate update, const std::string& editor) {
  update.set_single_editor(true);
  update.set_editor_id(editor);
  return update;
}

std::vector<std::string> IdsOf(const Attendance& attendance) {
  std::vector<std::string> ids;
  for (const Participant& other : attendance.others) ids.push_back(other.id);
  return ids;
}

TEST(AttendanceBookTest, ChangesAreLaidOverTheList) {
  AttendanceBook book;
  book.Begin("me");
  EXPECT_FALSE(book.now().is_current);
  book.Apply(Everybody({"b", "a"}));
  EXPECT_TRUE(book.now().is_current);
  v1::PresenceUpdate update = Everybody({"c", "a"});
  update.set_is_everything(false);
  update.mutable_participants(1)->mutable_presence()->set_colour_rgb(7);
  update.add_left("b");
  book.Apply(update);
  EXPECT_THAT(IdsOf(book.now()), ElementsAre("a", "c")) << "those who came first come first";
  EXPECT_EQ(book.now().others[0].presence.colour_rgb, 7u);
  book.Apply(Everybody({"c", "d"}));
  EXPECT_THAT(IdsOf(book.now()), ElementsAre("c", "d")) << "whoever is not in it has left";
}

TEST(AttendanceBookTest, WhatNoServerTellsIsNotTakenIn) {
  AttendanceBook book;
  book.Begin("me");
  v1::PresenceUpdate crowd;
  crowd.set_is_everything(true);
  while (crowd.participants_size() < 4'096) {
    crowd.add_participants()->set_participant_id(std::to_string(crowd.participants_size()));
  }
  EXPECT_EQ(book.Check(crowd), absl::OkStatus());
  book.Apply(crowd);
  crowd.set_is_everything(false);
  EXPECT_EQ(book.Check(crowd), absl::OkStatus()) << "all of them move";
  book.Apply(crowd);
  for (v1::Participant& one : *crowd.mutable_participants()) {
    one.set_participant_id("another " + one.participant_id());
  }
  book.Apply(crowd);
  EXPECT_EQ(book.Check(Everybody({"a"})), absl::OkStatus());
  EXPECT_EQ(book.Check(crowd).code(), absl::StatusCode::kDataLoss) << "they become ever more";
  crowd.set_is_everything(true);
  crowd.add_participants();
  EXPECT_EQ(book.Check(crowd).code(), absl::StatusCode::kDataLoss);

  auto talker = Everybody({"a"});
  talker.mutable_participants(0)->mutable_presence()->set_display_name(std::string(40'000, 'a'));
  EXPECT_EQ(book.Check(talker).code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(book.Check(Everybody({std::string(257, 'a')})).code(), absl::StatusCode::kDataLoss);
}

TEST(AttendanceBookTest, ThoseWeWereAreNobody) {
  AttendanceBook book;
  book.Begin("first");
  book.Apply(Edits(Everybody({"bob"}), "first"));
  EXPECT_TRUE(book.now().edits_self());
  book.Lose();
  EXPECT_FALSE(book.now().is_current);
  EXPECT_THAT(IdsOf(book.now()), ElementsAre("bob")) << "as it was";
  book.Begin("second");
  book.Apply(Edits(Everybody({"bob", "first"}), "first"));
  EXPECT_THAT(IdsOf(book.now()), ElementsAre("bob"));
  EXPECT_FALSE(book.now().edits_self());
  EXPECT_TRUE(book.editor_is_ghost());
  EXPECT_TRUE(book.has_lost_editing());
  book.Apply(Edits(Everybody({"bob"}), "second"));
  EXPECT_TRUE(book.now().edits_self());
  EXPECT_FALSE(book.has_lost_editing()) << "it is back";
}

TEST(AttendanceBookTest, EditingIsLostForGoodToWhoeverTookIt) {
  for (const bool is_taken : {true, false}) {
    AttendanceBook book;
    book.Begin("first");
    book.Apply(Edits(Everybody({"bob"}), "first"));
    book.Lose();
    book.Lose();  // a connection that never came about
    book.Begin("second");
    book.Apply(Edits(Everybody({"bob"}), is_taken ? "bob" : ""));
    EXPECT_EQ(book.has_lost_editing(), !is_taken);
    book.Apply(Edits(Everybody({"bob"}), ""));
    EXPECT_EQ(book.has_lost_editing(), !is_taken) << "even if they leave it";
    book.Apply(Everybody({"bob"}));
    EXPECT_FALSE(book.has_lost_editing()) << "everybody may edit";
  }
}

TEST(AttendanceBookTest, AnswersCountUntilTheListComes) {
  AttendanceBook book;
  book.Begin("first");
  book.Apply(Edits(Everybody({"bob"}), "first"));
  book.NoteAnswer(false);
  book.Lose();
  EXPECT_FALSE(book.has_lost_editing()) << "it was given away";
  book.Begin("second");
  book.Apply(Edits(Everybody({"bob"}), ""));
  book.NoteAnswer(true);
  book.Lose();
  EXPECT_TRUE(book.has_lost_editing()) << "it was taken";
}

TEST(AttendanceBookTest, ACameraThatIsNoneIsLeftOut) {
  v1::Presence proto;
  proto.set_display_name("Ada");
  proto.mutable_camera()->mutable_eye()->set_x(std::numeric_limits<float>::quiet_NaN());
  EXPECT_FALSE(FromProto(proto).view);
  EXPECT_EQ(FromProto(proto).display_name, "Ada");
}

TEST(AttendanceBookTest, PresenceKeepsAllItHasOnTheWire) {
  const Presence presence{.display_name = "Åsa",
                          .colour_rgb = 0x123456,
                          .view = View{.camera = {.eye = {1, 2, 3}, .fov_y_deg = 30}, .aspect = 2},
                          .selected_ids = {"box", "lamp"}};
  EXPECT_EQ(FromProto(ToProto(presence)), presence);
  EXPECT_EQ(FromProto(ToProto(Presence{})), Presence{});
}

TEST(AttendanceBookTest, DifferencesSayWhoCameWentAndChanged) {
  const Attendance before{.own_id = "me",
                          .others = {{"a", {.display_name = "Ada"}}, {"b", {}}, {"c", {}}},
                          .is_current = true};
  Attendance now = before;
  EXPECT_FALSE(IsNews(Difference(before, now), before));
  now.others = {{"a", {.display_name = "Ada Lovelace"}}, {"c", {}}, {"d", {}}};
  now.single_editor = true;
  const PresenceChange change = Difference(before, now);
  EXPECT_TRUE(IsNews(change, before));
  EXPECT_THAT(change.changed, ElementsAre("a"));
  EXPECT_THAT(change.joined, ElementsAre("d"));
  ASSERT_EQ(change.left.size(), 1u);
  EXPECT_EQ(change.left[0].id, "b");
  EXPECT_TRUE(change.editing_has_changed);
  Attendance offline = before;
  offline.is_current = false;
  EXPECT_THAT(Difference(before, offline).left, IsEmpty());
  EXPECT_TRUE(IsNews(Difference(before, offline), before));
}

}  // namespace
}  // namespace penumbra::testing
