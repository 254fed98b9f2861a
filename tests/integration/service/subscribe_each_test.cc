// Many subscriptions by one request, over a real connection.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/convert/spec_convert.h"
#include "proto/convert/status_convert.h"
#include "render/engine/compute_once.h"
#include "render/engine/local_engine.h"
#include "render/scene/field_error.h"
#include "tests/integration/service/studio.h"

namespace penumbra::testing {
namespace {

using ::testing::ElementsAre;

class SubscribeEachTest : public StudioTest {
 protected:
  // A box whose six faces receive, in two lights.
  void SetUp() override {
    StudioTest::SetUp();
    SceneDelta more;
    more.upsert_lights = {{.id = "sun", .shape = DistantLight{.to_light = {1, 2, 0}}}};
    more.remove_receivers = {"floor"};
    more.receive_on_planar_surfaces = PlanarSurfaceRequest{};
    content_ = StudioDelta();
    content_.upsert_lights.push_back(more.upsert_lights[0]);
    content_.upsert_receivers.clear();
    content_.receive_on_planar_surfaces = more.receive_on_planar_surfaces;
    const auto result = session_->Commit(more);
    ASSERT_EQ(result.revision(), 2u) << result.error().message();
  }

  v1::SubscribeEachResult Ask(const v1::SubscribeEach& each) {
    v1::SessionRequest request;
    *request.mutable_subscribe_each() = each;
    session_->Send(request);
    return session_->ReadUntil(v1::SessionResponse::kSubscribeEachResult)->subscribe_each_result();
  }
  v1::SubscribeEach Each(uint64_t first_id) {
    v1::SubscribeEach each;
    each.set_first_subscription_id(first_id);
    *each.mutable_technique() = ToProto(ArtifactSpec{SoftTextureParams{.samples = 16}, "", ""});
    each.set_initial_credit(4);
    return each;
  }

  SceneDelta content_;
};

TEST_F(SubscribeEachTest, EveryLightOnEveryReceiverIsSubscribed) {
  const auto result = Ask(Each(100));
  ASSERT_FALSE(result.has_error()) << result.error().message();
  EXPECT_EQ(result.first_subscription_id(), 100u);
  EXPECT_THAT(result.light_ids(), ElementsAre("lamp", "sun"));
  ASSERT_EQ(result.receiver_ids_size(), 6);
  LocalEngine engine({.cpu_threads = 1});
  ASSERT_EQ(engine.CreateScene("studio"), absl::OkStatus());
  ASSERT_TRUE(engine.Commit("studio", content_).ok());
  uint64_t id = 100;
  for (const std::string& receiver : result.receiver_ids()) {
    for (const std::string& light : result.light_ids()) {
      const auto update = session_->AwaitUpdate(id++, IsFinal);
      EXPECT_EQ(update.artifact->header.receiver_id, receiver);
      EXPECT_EQ(update.artifact->header.light_id, light);
      const auto expected =
          ComputeOnce(engine, "studio", {SoftTextureParams{.samples = 16}, light, receiver}, {});
      ASSERT_TRUE(expected.ok());
      EXPECT_EQ(TextureOf(update).visibility.counts,
                std::get<SoftShadowTexture>((*expected)->payload).visibility.counts);
    }
  }
  EXPECT_EQ(client_->ServerInfo().statistics().open_subscriptions(), 12u);
}

TEST_F(SubscribeEachTest, SomeMayBeNamedAndEachEndsOnItsOwn) {
  v1::SubscribeEach each = Each(7);
  each.add_light_ids("sun");
  each.add_receiver_ids("surface.box.0");
  each.add_receiver_ids("surface.box.4");
  const auto result = Ask(each);
  ASSERT_FALSE(result.has_error()) << result.error().message();
  EXPECT_THAT(result.receiver_ids(), ElementsAre("surface.box.0", "surface.box.4"));
  v1::SessionRequest end;
  end.mutable_unsubscribe()->set_subscription_id(7);
  session_->Send(end);
  session_->ReadUntil(v1::SessionResponse::kSubscriptionEnded);
  EXPECT_EQ(client_->ServerInfo().statistics().open_subscriptions(), 1u);
  session_->AwaitUpdate(8, IsFinal);
}

TEST_F(SubscribeEachTest, WrongOnesMakeNothing) {
  const auto reason = [&](const std::function<void(v1::SubscribeEach&)>& spoil) {
    v1::SubscribeEach each = Each(1);
    spoil(each);
    const auto result = Ask(each);
    EXPECT_EQ(result.receiver_ids_size(), 0);
    EXPECT_EQ(client_->ServerInfo().statistics().open_subscriptions(), 0u);
    return ErrorReason(FromProto(result.error()));
  };
  EXPECT_EQ(reason([](auto& each) { each.add_light_ids("ghost"); }), "UNKNOWN_ID");
  EXPECT_EQ(reason([](auto& each) { each.add_receiver_ids("ghost"); }), "UNKNOWN_ID");
  EXPECT_EQ(reason([](auto& each) { each.add_light_ids("a b"); }), "BAD_ID");
  EXPECT_EQ(reason([](auto& each) { each.clear_technique(); }), "UNKNOWN_TECHNIQUE");
  EXPECT_EQ(reason([](auto& each) { each.set_first_subscription_id(~uint64_t{0} - 3); }), "RANGE");
  EXPECT_EQ(reason([](auto& each) {
              each.mutable_technique()->mutable_soft_texture()->set_samples(5000);
            }),
            "RANGE");
  EXPECT_EQ(reason([](auto& each) {
              each.add_light_ids("sun");
              each.add_light_ids("sun");
            }),
            "DUPLICATE_ID");
  ASSERT_EQ(session_->Subscribe(5, {SoftTextureParams{}, "sun", "surface.box.0"}, 4),
            absl::OkStatus());
  const auto taken = Ask(Each(1));
  EXPECT_EQ(FromProto(taken.error()).code(), absl::StatusCode::kAlreadyExists);
  EXPECT_EQ(client_->ServerInfo().statistics().open_subscriptions(), 1u);
}

TEST_F(SubscribeEachTest, MoreThanASessionMayHaveAreRefusedBeforeAnythingIsMade) {
  SceneDelta lights;
  for (int i = 0; i < 200; ++i) {
    lights.upsert_lights.push_back({.id = "point" + std::to_string(i), .shape = PointLight{}});
  }
  session_->Commit(lights);
  const auto before = client_->ServerInfo().statistics().jobs_started();
  const auto status = FromProto(Ask(Each(1)).error());
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ErrorReason(status), "QUOTA_SUBSCRIPTIONS");
  EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr("1212 to make"));
  EXPECT_EQ(client_->ServerInfo().statistics().jobs_started(), before);
  EXPECT_EQ(client_->ServerInfo().statistics().open_subscriptions(), 0u);
}

TEST_F(SubscribeEachTest, AMaskTravelsOnceAndComesWhole) {
  SceneDelta polygon;
  polygon.upsert_receivers = {
      {.id = "l",
       .shape = PlanarPolygon{{{0, 0, 0}, {0, 0, 2}, {1, 0, 2}, {1, 0, 1}, {2, 0, 1}, {2, 0, 0}}},
       .width = 64,
       .height = 64}};
  session_->Commit(polygon);
  const ArtifactSpec spec{SoftTextureParams{.samples = 16}, "lamp", "l"};
  ASSERT_EQ(session_->Subscribe(1, spec, 4), absl::OkStatus());
  const auto first = session_->AwaitUpdate(1, IsFinal);
  ASSERT_NE(TextureOf(first).coverage, nullptr);
  EXPECT_EQ(TextureOf(first).coverage->CountInside(), 64u * 64 * 3 / 4);
  session_->Commit(MoveBox({0.7f, 1, 0.5f}));
  const auto second = session_->AwaitUpdate(1, FinalAt(4));
  EXPECT_NE(second.artifact, first.artifact);
  EXPECT_EQ(TextureOf(second).coverage, TextureOf(first).coverage) << "taken over as it was";
}

}  // namespace
}  // namespace penumbra::testing
