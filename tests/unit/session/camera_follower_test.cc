#include "client/session/camera_follower.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/scene/field_error.h"

namespace penumbra::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using State = FollowedCamera::State;

Participant Person(const std::string& id, const std::string& name, float eye_x) {
  return {id, {.display_name = name, .view = View{.camera = {.eye = {eye_x, 0, 5}}}}};
}

Attendance Here(std::vector<Participant> others) {
  return {.own_id = "me", .others = std::move(others), .is_current = true};
}

TEST(CameraFollowerTest, FollowsUntilTheyLeaveAndHoldsTheLastCamera) {
  CameraFollower follower("Ada");
  FollowedCamera seen = follower.Look(Here({}));
  EXPECT_EQ(seen.state, State::kNotHere);
  EXPECT_FALSE(seen.view);
  EXPECT_EQ(seen.reason, "nobody called \"Ada\" is here");

  seen = follower.Look(Here({Person("b", "Bob", 1), Person("a", "Ada", 2)}));
  ASSERT_TRUE(seen.is_followed());
  EXPECT_TRUE(seen.is_new);
  EXPECT_EQ(seen.view->camera.eye.x, 2);
  EXPECT_FALSE(follower.Look(Here({Person("a", "Ada", 2)})).is_new) << "the same camera";
  seen = follower.Look(Here({Person("a", "Ada", 3)}));
  EXPECT_TRUE(seen.is_new);

  seen = follower.Look(Here({Person("b", "Bob", 1)}));
  EXPECT_EQ(seen.state, State::kLeft);
  EXPECT_EQ(seen.reason, "Ada has left");
  ASSERT_TRUE(seen.view);
  EXPECT_EQ(seen.view->camera.eye.x, 3) << "the last one";
  EXPECT_FALSE(seen.is_new);

  seen = follower.Look(Here({Person("a2", "Ada", 4)}));
  EXPECT_TRUE(seen.is_followed()) << "back on another connection";
  EXPECT_EQ(seen.view->camera.eye.x, 4);
}

TEST(CameraFollowerTest, WhoeverIsNotFoundIsSoughtAmongThoseWhoAreHere) {
  EXPECT_EQ(WhoIsHere(Here({})), "nobody else is here");
  EXPECT_EQ(WhoIsHere(Here({Person("a", "Ada", 1), Person("b", "Bob", 2)})), "here are: Ada, Bob");
  const auto found = FindParticipant(Here({}), "Eve");
  EXPECT_EQ(found.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(found.status().message()),
              AllOf(HasSubstr("\"Eve\""), HasSubstr("nobody else is here")));
}

TEST(CameraFollowerTest, AnotherOfTheSameNameChangesNothing) {
  CameraFollower follower("Ada");
  ASSERT_TRUE(follower.Look(Here({Person("a", "Ada", 2)})).is_followed());
  const auto seen = follower.Look(Here({Person("x", "Ada", 9), Person("a", "Ada", 2)}));
  EXPECT_TRUE(seen.is_followed());
  EXPECT_EQ(seen.view->camera.eye.x, 2);
}

TEST(CameraFollowerTest, SeveralOfANameNeedAnId) {
  const Attendance two = Here({Person("x", "Ada", 9), Person("y", "Ada", 2)});
  CameraFollower by_name("Ada");
  const auto seen = by_name.Look(two);
  EXPECT_EQ(seen.state, State::kSeveral);
  EXPECT_THAT(seen.reason, AllOf(HasSubstr("found 2 people"), HasSubstr("one of: x, y")));
  EXPECT_EQ(CameraFollower("y").Look(two).view->camera.eye.x, 2);
  EXPECT_EQ(ErrorReason(FindParticipant(two, "Ada").status()), "AMBIGUOUS_NAME");
  const absl::Status nobody = FindParticipant(two, "Bob").status();
  EXPECT_EQ(nobody.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(nobody.message()), HasSubstr("here are: Ada, Ada"));
}

TEST(CameraFollowerTest, WithoutACameraOrAConnectionTheLastOneStays) {
  CameraFollower follower("a");
  ASSERT_TRUE(follower.Look(Here({Person("a", "Ada", 2)})).is_followed());
  Attendance lost = Here({Person("a", "Ada", 2)});
  lost.is_current = false;
  EXPECT_EQ(follower.Look(lost).state, State::kConnecting);
  Participant blind = Person("a", "Ada", 2);
  blind.presence.view.reset();
  const auto seen = follower.Look(Here({blind}));
  EXPECT_EQ(seen.state, State::kNoCamera);
  EXPECT_EQ(seen.view->camera.eye.x, 2);
}

}  // namespace
}  // namespace penumbra::testing
