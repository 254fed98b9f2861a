// What a RemoteEngine makes of bad input, and of a server that goes away.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "render/scene/field_error.h"
#include "tests/integration/session/remote_engine_fixture.h"

namespace penumbra::testing {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;

TEST_F(RemoteEngineTest, BadInputIsRefusedByFieldAndTheSessionGoesOn) {
  const auto engine = Connect();
  ASSERT_EQ(engine->CreateScene("studio"), absl::OkStatus());
  ASSERT_TRUE(engine->Commit("studio", Studio()).ok());

  SceneDelta bad = Studio();
  std::get<RectangleLight>(bad.upsert_lights[0].shape).edge_v = Vec3(NAN, 0, 1);
  const auto refused = engine->Commit("studio", bad);
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ErrorReason(refused.status()), "NON_FINITE");
  EXPECT_EQ(ErrorFieldPath(refused.status()), "upsert_lights[0].edge_v");

  SceneDelta stale = Studio();
  stale.base_revision = 0;
  const auto aborted = engine->Commit("studio", stale);
  EXPECT_EQ(aborted.status().code(), absl::StatusCode::kAborted);
  EXPECT_EQ(ErrorReason(aborted.status()), "STALE_BASE");

  Inbox inbox;
  const auto none = engine->Subscribe("studio", FloorSpec(0), inbox.callback());
  EXPECT_EQ(none.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(none.status().message()), HasSubstr("samples"));

  EXPECT_EQ((*engine->Snapshot("studio"))->revision(), 1u);
  EXPECT_EQ(engine->Commit("studio", Studio(Vec3(0.2f, 0.5f, 0))).value(), 2u);
  EXPECT_TRUE(ComputeOnce(*engine, "studio", FloorSpec()).ok());
}

TEST_F(RemoteEngineTest, ADeltaThatNoMessageHoldsIsRefusedBeforeItIsSent) {
  const auto engine = Connect();
  ASSERT_EQ(engine->CreateScene("studio"), absl::OkStatus());
  SceneDelta delta;
  for (int i = 0; i < 20'000; ++i) {
    Instance box = Studio().upsert_instances[0];
    box.id = "a-box-whose-name-takes-its-share-of-the-message-" + std::to_string(i);
    delta.upsert_instances.push_back(std::move(box));
  }
  const auto refused = engine->Commit("studio", delta);
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(refused.status().message()), HasSubstr("delta: found"));
  EXPECT_EQ(engine->Commit("studio", Studio()).value(), 1u);
}

// gRPC would end the session over it, and the next one too.
TEST_F(RemoteEngineTest, ASubscriptionThatNoMessageHoldsIsRefusedBeforeItIsSent) {
  const auto engine = Connect(/*reconnect_for_s=*/10);
  ASSERT_EQ(engine->CreateScene("studio"), absl::OkStatus());
  ASSERT_TRUE(engine->Commit("studio", Studio()).ok());
  const PointReceiver points =
      GivenPoints{std::make_shared<const std::vector<SurfacePoint>>(200'000, SurfacePoint{})};
  const std::string field_of[] = {"spec: found", "subscribe_each: found"};
  const absl::Status refused[] = {
      engine
          ->Subscribe("studio",
                      {.params = CoherentRaytraceParams{}, .light_id = "lamp", .points = points},
                      [](const ArtifactUpdate&) {})
          .status(),
      engine
          ->SubscribeEach("studio", {.params = CoherentRaytraceParams{}, .points = points},
                          [](const auto&, const auto&, const auto&) {})
          .status()};
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(ErrorReason(refused[i]), "QUOTA_MESSAGE") << refused[i];
    EXPECT_THAT(std::string(refused[i].message()), HasSubstr(field_of[i]));
  }
  EXPECT_TRUE(ComputeOnce(*engine, "studio", FloorSpec()).ok()) << "the session goes on";
}

TEST_F(RemoteEngineTest, UnknownAndDuplicateScenesAreTold) {
  const auto engine = Connect();
  EXPECT_EQ(engine->Commit("nowhere", Studio()).status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(engine->Snapshot("nowhere").status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(engine->Subscribe("nowhere", FloorSpec(), [](const ArtifactUpdate&) {}).status().code(),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(engine->DeleteScene("nowhere").code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(engine->CreateScene("a b").code(), absl::StatusCode::kInvalidArgument);
  ASSERT_EQ(engine->CreateScene("studio"), absl::OkStatus());
  EXPECT_EQ(engine->CreateScene("studio").code(), absl::StatusCode::kAlreadyExists);
}

TEST_F(RemoteEngineTest, AServerThatGoesAwayEndsEverythingWithUnavailable) {
  const auto engine = Connect();
  ASSERT_EQ(engine->CreateScene("studio"), absl::OkStatus());
  ASSERT_TRUE(engine->Commit("studio", Studio()).ok());
  Inbox inbox;
  const auto subscription = engine->Subscribe("studio", FloorSpec(), inbox.callback());
  ASSERT_TRUE(subscription.ok());
  ASSERT_TRUE(inbox.WaitForFinal(1));
  server_->Shutdown(seconds(2));
  server_.reset();

  const auto end = inbox.WaitForError(absl::StatusCode::kUnavailable);
  ASSERT_TRUE(end);
  EXPECT_THAT(std::string(end->status.message()), HasSubstr("127.0.0.1"));
  EXPECT_EQ(engine->Commit("studio", Studio()).status().code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(engine->CreateScene("other").code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(ComputeOnce(*engine, "studio", FloorSpec()).status().code(),
            absl::StatusCode::kUnavailable);
}

TEST_F(RemoteEngineTest, AfterTheServerIsBackCallsReachIt) {
  const std::string address = server_->address();
  const auto engine = Connect();
  ASSERT_EQ(engine->CreateScene("studio"), absl::OkStatus());
  ASSERT_TRUE(engine->Commit("studio", Studio()).ok());
  server_->Shutdown(seconds(2));
  server_.reset();
  ASSERT_EQ(engine->Commit("studio", Studio()).status().code(), absl::StatusCode::kUnavailable);
  Start(address);
  absl::Status created;
  for (const auto end = std::chrono::steady_clock::now() + kPatience;
       std::chrono::steady_clock::now() < end;) {
    created = engine->CreateScene("studio");
    if (created.ok()) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  ASSERT_EQ(created, absl::OkStatus());
  EXPECT_EQ(engine->Commit("studio", Studio()).value(), 1u);
}

TEST_F(RemoteEngineTest, NoServerIsToldAtOnceAndOnOneLine) {
  const std::string address = server_->address();
  server_.reset();
  const auto start = std::chrono::steady_clock::now();
  const auto engine = RemoteEngine::Connect({.address = address});
  EXPECT_EQ(engine.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(engine.status().message()), HasSubstr(address + ": no server answers"));
  EXPECT_LT(std::chrono::steady_clock::now() - start, seconds(5));
}

TEST_F(RemoteEngineTest, TheEngineAndItsSubscriptionsMayDieInAnyOrder) {
  auto engine = Connect();
  ASSERT_EQ(engine->CreateScene("studio"), absl::OkStatus());
  ASSERT_TRUE(engine->Commit("studio", Studio()).ok());
  Inbox inbox;
  auto subscription = engine->Subscribe("studio", FloorSpec(), inbox.callback());
  ASSERT_TRUE(subscription.ok());
  engine.reset();
  subscription->reset();
}

TEST_F(RemoteEngineTest, TheServerDescribesItself) {
  const auto engine = Connect();
  const auto info = engine->ServerInfoJson();
  ASSERT_TRUE(info.ok()) << info.status();
  EXPECT_THAT(*info, HasSubstr("\"server_name\":\"penumbra"));
  EXPECT_THAT(*info, HasSubstr("max_light_samples"));
  const auto techniques = engine->TechniquesJson();
  ASSERT_TRUE(techniques.ok()) << techniques.status();
  EXPECT_THAT(*techniques, HasSubstr("\"name\":\"soft_texture\""));
}

}  // namespace
}  // namespace penumbra::testing
