// What a session has for a client that reads less than happens.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "proto/convert/spec_convert.h"
#include "proto/convert/status_convert.h"
#include "render/scene/field_error.h"
#include "tests/integration/service/unconnected_session.h"

namespace penumbra::testing {
namespace {

TEST(UnreadSessionTest, C21ComputingThatComesAndGoesIsOneMessage) {
  UnconnectedSession parts({.compute_s_per_minute = 1});
  parts.Hello("ana");
  while (parts.Next()) {
  }
  const auto use_up = [&] {
    parts.quotas().Charge(parts.principal(), 1'100);
    parts.session().TellOfCompute();
  };
  const auto get_back = [&] {
    parts.Pass(std::chrono::minutes(2));
    parts.session().TellOfCompute();
  };
  for (int i = 0; i < 100; ++i) {
    use_up();
    get_back();
  }
  EXPECT_TRUE(parts.session().has_room()) << "no replies that wait to be read";
  EXPECT_FALSE(parts.Next()) << "all is as the client knows it";
  use_up();
  const auto used_up = parts.Next();
  ASSERT_TRUE(used_up);
  EXPECT_EQ(ErrorReason(FromProto(used_up->compute_quota().error())), "QUOTA_COMPUTE");
  EXPECT_FALSE(parts.Next());
  get_back();
  const auto back = parts.Next();
  ASSERT_TRUE(back);
  EXPECT_TRUE(back->has_compute_quota());
  EXPECT_FALSE(back->compute_quota().has_error());
  EXPECT_FALSE(parts.Next());

  EXPECT_TRUE(parts.log().All("refused").empty()) << "nothing was";
  const auto noted = parts.log().All("over_quota");
  ASSERT_EQ(noted.size(), 101u);
  EXPECT_EQ(noted[0]["reason"], "QUOTA_COMPUTE");
  EXPECT_EQ(noted[0]["session"], 1);
}

TEST(UnreadSessionTest, RepliesThatWaitToBeReadAreBounded) {
  UnconnectedSession parts;
  parts.Hello("ana");
  while (parts.Next()) {
  }
  v1::SessionRequest request;
  request.mutable_credit()->set_subscription_id(7);  // of which there is none: that is answered
  for (size_t i = 0; i < ServerLimits().max_queued_replies; ++i) {
    EXPECT_TRUE(parts.session().has_room()) << i;
    parts.Send(request);
  }
  EXPECT_FALSE(parts.session().has_room()) << "no further request is read";
  const auto reply = parts.Next();
  ASSERT_TRUE(reply);
  EXPECT_TRUE(reply->has_session_error());
  EXPECT_TRUE(parts.session().has_room());
}

// There is something new to tell of others whenever a message has been taken.
TEST(UnreadSessionTest, ArtifactsHaveTheirTurnInACrowd) {
  UnconnectedSession parts;
  const auto room = parts.room(parts.Hello("ana"));
  const std::string other = room->Join({}, {});
  v1::SessionRequest subscribe;
  subscribe.mutable_subscribe()->set_subscription_id(1);
  *subscribe.mutable_subscribe()->mutable_spec() = ToProto(FloorSpec());
  subscribe.mutable_subscribe()->set_initial_credit(100);
  parts.Send(subscribe);
  int of_others = 0, artifacts = 0;
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (artifacts == 0 && std::chrono::steady_clock::now() < end) {
    room->Report(other, {});
    parts.session().OnPresenceChanged();
    const auto response = parts.Next();
    ASSERT_TRUE(response);
    of_others += response->has_presence_update();
    artifacts += response->has_artifact_update();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_GT(of_others, 0);
  EXPECT_EQ(artifacts, 1);
}

}  // namespace
}  // namespace penumbra::testing
