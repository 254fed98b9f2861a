// What those who run a server see of it: its log, metrics, health and status.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "proto/convert/status_convert.h"
#include "render/scene/field_error.h"
#include "tests/integration/service/health_watch.h"
#include "tests/integration/service/kept_log.h"
#include "tests/integration/service/studio.h"
#include "tests/support/http_get.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;
using std::chrono::milliseconds, std::chrono::seconds, std::chrono::steady_clock;

class OperationsTest : public StudioTest {
 protected:
  void SetUp() override {
    options_.logger = &log_;
    options_.metrics_listen = "127.0.0.1:0";
    StudioTest::SetUp();
  }
  // The log outlives the server.
  void TearDown() override {
    session_.reset();
    server_.reset();
  }

  std::string Metrics() { return HttpGet(server_->metrics_address(), "/metrics"); }

  // A session by a client of that name.
  std::unique_ptr<WireSession> OpenAs(const std::string& client_name) {
    auto session = std::make_unique<WireSession>(client_->stub());
    v1::SessionRequest request;
    request.mutable_hello()->set_scene_id("studio");
    request.mutable_hello()->add_protocol_versions(1);
    request.mutable_hello()->set_client_name(client_name);
    session->Send(request);
    EXPECT_TRUE(session->ReadUntil(v1::SessionResponse::kWelcome));
    return session;
  }

  v1::GetServerStatusResponse Status() {
    grpc::ClientContext context;
    v1::GetServerStatusResponse response;
    const auto status =
        client_->stub().GetServerStatus(&context, v1::GetServerStatusRequest(), &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response;
  }

  KeptLog log_;
};

TEST_F(OperationsTest, SessionsAreLoggedFromTheirHelloToTheirEnd) {
  const auto before = log_.Await("session_opened", 1);
  auto other = OpenAs("a viewer");
  const Json opened = log_.Await("session_opened", 2)[1];
  EXPECT_EQ(opened["scene"], "studio");
  EXPECT_EQ(opened["client"], "a viewer");
  EXPECT_NE(opened["session"], before[0]["session"]);
  other->Commit(MoveBox({0, 2, 0}));
  other->Cancel();
  const Json ended = log_.Await("session_ended", 1)[0];
  EXPECT_EQ(ended["session"], opened["session"]);
  EXPECT_THAT(ended["reason"], ::testing::AnyOf("OK", "CANCELLED")) << "as gRPC tells it first";
  EXPECT_EQ(ended["commits"], 1);
  EXPECT_GT(ended["sent_bytes"], 100);
}

TEST_F(OperationsTest, RefusalsAreLoggedByReasonAndFieldWithoutWhatWasSent) {
  const std::string secret = "no/such scene";
  EXPECT_FALSE(client_->CreateScene(secret).ok());
  const Json refused = log_.Await("refused", 1)[0];
  EXPECT_EQ(refused["call"], "CreateScene");
  EXPECT_EQ(refused["code"], "INVALID_ARGUMENT");
  EXPECT_EQ(refused["reason"], "BAD_ID");
  EXPECT_EQ(refused["field"], "scene_id");
  EXPECT_TRUE(refused["request"].is_number());
  EXPECT_THAT(refused.dump(), Not(HasSubstr(secret)));

  SceneDelta delta = MoveBox({0, 2, 0});
  delta.upsert_instances[0].id = "../passwd";
  EXPECT_NE(session_->Commit(delta).error().code(), 0);
  const Json commit = log_.Await("refused", 2)[1];
  EXPECT_EQ(commit["call"], "commit");
  EXPECT_EQ(commit["reason"], "BAD_ID");
  EXPECT_EQ(commit["session"], log_.All("session_opened")[0]["session"]);
  EXPECT_EQ(SampleIn(Metrics(), "penumbra_failures_total{reason=\"BAD_ID\"}"), 2);
}

TEST_F(OperationsTest, AHelloThatIsRefusedIsNoSessionInTheLog) {
  WireSession session(client_->stub());
  v1::SessionRequest request;
  request.mutable_hello()->set_scene_id("ghost");
  request.mutable_hello()->add_protocol_versions(1);
  session.Send(request);
  EXPECT_EQ(session.End().code(), absl::StatusCode::kNotFound);
  const Json refused = log_.Await("refused", 1)[0];
  EXPECT_EQ(refused["call"], "hello");
  EXPECT_EQ(refused["reason"], "UNKNOWN_ID");
  EXPECT_EQ(log_.All("session_opened").size(), 1u) << "the fixture's";
}

TEST_F(OperationsTest, E16MetricsCountWhatHappenedAndNameNobody) {
  auto viewer = OpenAs("viewer-name");
  ASSERT_EQ(viewer->Subscribe(1, FloorSpec(), 8), absl::OkStatus());
  viewer->AwaitUpdate(1, IsFinal);
  viewer->Cancel();
  log_.Await("session_ended", 1);
  const std::string text = Metrics();
  EXPECT_EQ(SampleIn(text, "penumbra_open_sessions"), 1);
  EXPECT_EQ(SampleIn(text, "penumbra_scenes"), 1);
  EXPECT_EQ(SampleIn(text, "penumbra_commits_total"), 1);
  EXPECT_GE(SampleIn(text, "penumbra_updates_sent_total"), 1);
  EXPECT_EQ(SampleIn(text, "penumbra_jobs_total{outcome=\"finished\"}"), 1);
  EXPECT_EQ(SampleIn(text, "penumbra_job_compute_seconds_count{technique=\"soft_texture\"}"), 1);
  EXPECT_EQ(SampleIn(text, "penumbra_final_artifact_seconds_count"), 1);
  EXPECT_GE(SampleIn(text, "penumbra_encode_seconds_count"), 1);
  EXPECT_EQ(SampleIn(text, "penumbra_session_sent_bytes_count"), 1);
  EXPECT_EQ(SampleIn(text, "penumbra_session_sent_bytes_sum") > 0, true);
  EXPECT_EQ(SampleIn(text, "penumbra_calls_total{code=\"OK\",method=\"CreateScene\"}"), 1);
  EXPECT_EQ(SampleIn(text, "penumbra_degraded"), 1);
  EXPECT_GT(SampleIn(text, "penumbra_blob_bytes"), 0);
  for (const char* name : {"studio", "viewer-name", "lamp", "floor"}) {
    EXPECT_THAT(text, Not(HasSubstr(name))) << "is for those who may see scenes";
  }
}

TEST_F(OperationsTest, WhoeverSubscribesToWhatIsComputedIsAHit) {
  ASSERT_EQ(session_->Subscribe(1, FloorSpec(), 8), absl::OkStatus());
  session_->AwaitUpdate(1, IsFinal);
  const std::string first = Metrics();
  EXPECT_EQ(SampleIn(first, "penumbra_artifact_cache_lookups_total{result=\"hit\"}"), 0);
  EXPECT_EQ(SampleIn(first, "penumbra_artifact_cache_lookups_total{result=\"miss\"}"), 1);
  auto viewer = OpenAs("viewer");
  ASSERT_EQ(viewer->Subscribe(1, FloorSpec(), 8), absl::OkStatus());
  viewer->AwaitUpdate(1, IsFinal);
  const std::string second = Metrics();
  EXPECT_EQ(SampleIn(second, "penumbra_artifact_cache_lookups_total{result=\"hit\"}"), 1);
  EXPECT_EQ(SampleIn(second, "penumbra_artifact_cache_lookups_total{result=\"miss\"}"), 1);
}

TEST_F(OperationsTest, TheStatusTellsOfEachSceneAndClient) {
  ASSERT_EQ(client_->CreateScene("another"), absl::OkStatus());
  auto viewer = OpenAs("viewer");
  ASSERT_EQ(viewer->Subscribe(1, FloorSpec(), 8), absl::OkStatus());
  viewer->AwaitUpdate(1, IsFinal);
  const auto status = Status();
  ASSERT_EQ(status.scenes_size(), 2);
  EXPECT_EQ(status.scenes(0).scene_id(), "another");
  EXPECT_EQ(status.scenes(0).clients(), 0u);
  EXPECT_EQ(status.scenes(1).scene_id(), "studio");
  EXPECT_EQ(status.scenes(1).revision(), 1u);
  EXPECT_EQ(status.scenes(1).clients(), 2u);
  EXPECT_EQ(status.scenes(1).artifacts(), 1u);
  EXPECT_EQ(status.scenes(1).objects(), 3u);
  ASSERT_EQ(status.clients_size(), 2);
  EXPECT_EQ(status.clients(0).commits(), 1u);
  EXPECT_EQ(status.clients(0).subscriptions(), 0u);
  EXPECT_EQ(status.clients(1).client_name(), "viewer");
  EXPECT_EQ(status.clients(1).subscriptions(), 1u);
  EXPECT_GE(status.clients(1).updates_sent(), 1u);
  EXPECT_GE(status.clients(1).sent_bytes(), viewer->update_bytes());
  EXPECT_EQ(status.statistics().open_calls(), 3u) << "two sessions, and this one";
  EXPECT_TRUE(status.is_degraded());
}

TEST_F(OperationsTest, UpdatesThatNewerOnesTookThePlaceOfAreCounted) {
  ASSERT_EQ(session_->Subscribe(1, FloorSpec(), 1), absl::OkStatus());
  session_->ReadUntil(v1::SessionResponse::kArtifactUpdate);
  // Without credit, these pile up to one; each is awaited, so that none melts into another before.
  const auto computed = [&] { return client_->ServerInfo().statistics().artifacts_encoded(); };
  for (int i = 1; i <= 5; ++i) {
    const uint64_t before = computed();
    ASSERT_EQ(session_->Commit(MoveBox({0.1f * static_cast<float>(i), 1, 0})).error().code(), 0);
    while (computed() == before) std::this_thread::sleep_for(milliseconds(5));
  }
  EXPECT_EQ(client_->ServerInfo().statistics().updates_skipped(), 0u);
  session_->GrantCredit(1, 1);
  session_->ReadUntil(v1::SessionResponse::kArtifactUpdate);
  EXPECT_GE(Status().clients(0).updates_skipped(), 4u);
  EXPECT_GE(SampleIn(Metrics(), "penumbra_updates_skipped_total"), 4);
}

TEST(PenumbraServerTest, AStatusThatWouldNotFitIsCut) {
  ServerOptions options;
  options.limits.max_message_bytes = 4096;
  const auto server = StartServer(options);
  WireClient client(server->address());
  for (int i = 0; i < 100; ++i) {
    ASSERT_EQ(client.CreateScene(std::string(100, 'x') + std::to_string(i)), absl::OkStatus());
  }
  grpc::ClientContext context;
  v1::GetServerStatusResponse response;
  ASSERT_TRUE(
      client.stub().GetServerStatus(&context, v1::GetServerStatusRequest(), &response).ok());
  EXPECT_GT(response.scenes_size(), 10);
  EXPECT_EQ(static_cast<uint64_t>(response.scenes_size()) + response.left_out(), 100u);
  EXPECT_LE(response.ByteSizeLong(), 4096u);
}

TEST(DrainTest, HealthFirstThenNoAdmissionsThenTheSessions) {
  KeptLog log;
  ServerOptions options;
  options.logger = &log;
  auto server = StartServer(options);
  WireClient client(server->address());
  ASSERT_EQ(client.CreateScene("studio"), absl::OkStatus());
  HealthWatch whole(client.channel(), ""), service(client.channel(), "penumbra.v1.PenumbraService");
  HealthWatch gl(client.channel(), "penumbra.gl"), other(client.channel(), "no.such.Service");
  EXPECT_EQ(whole.Next(), HealthWatch::kServing);
  EXPECT_EQ(service.Next(), HealthWatch::kServing);
  EXPECT_EQ(gl.Next(), HealthWatch::kNotServing) << "there is no OpenGL";
  EXPECT_EQ(other.Next(), HealthWatch::kServiceUnknown);
  auto session = client.OpenSession("studio");

  const auto start = steady_clock::now();
  std::thread drain([&] { server->Shutdown(seconds(5)); });
  EXPECT_EQ(service.Next(), HealthWatch::kNotServing);
  EXPECT_EQ(whole.Next(), HealthWatch::kNotServing);
  // The session is still open: a request is answered.
  v1::SessionRequest request;
  request.mutable_unsubscribe()->set_subscription_id(9);
  session->Send(request);
  EXPECT_TRUE(session->ReadUntil(v1::SessionResponse::kSessionError));
  const absl::Status ended = session->End();
  EXPECT_EQ(ended.code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(ErrorReason(ended), "SHUTTING_DOWN");
  drain.join();
  EXPECT_LT(steady_clock::now() - start, seconds(4)) << "those who watch do not hold it up";
  EXPECT_EQ(service.Next(), HealthWatch::kEnded);
  std::vector<std::string> steps;
  for (const Json& event : log.All("drain_step")) steps.push_back(event["step"]);
  EXPECT_THAT(steps, ::testing::ElementsAre("health", "admissions", "sessions", "connections"));
  server.reset();
}

}  // namespace
}  // namespace penumbra::testing
