// Sessions with a server that speaks the protocol and means harm, or is broken.
#include "tests/support/hostile_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "client/session/scene_presence.h"
#include "client/session/scene_session.h"
#include "client/session/server_connection.h"
#include "google/protobuf/unknown_field_set.h"
#include "google/rpc/error_details.pb.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "proto/convert/status_convert.h"
#include "render/scene/field_error.h"
#include "tests/integration/session/remote_engine_fixture.h"

namespace penumbra::testing {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;

class HostileServerTest : public ::testing::Test {
 protected:
  std::unique_ptr<RemoteEngine> Connect(const HostileServer& server, double reconnect_for_s) {
    return RemoteEngine::Connect({.address = server.address(),
                                  .reconnect_for_s = reconnect_for_s,
                                  .on_connection =
                                      [this](const ConnectionEvent& event) {
                                        std::lock_guard lock(mutex_);
                                        events_.push_back(event.kind);
                                      }})
        .value();
  }
  std::vector<ConnectionEvent::Kind> events() {
    std::lock_guard lock(mutex_);
    return events_;
  }

  std::mutex mutex_;
  std::vector<ConnectionEvent::Kind> events_;
};

TEST_F(HostileServerTest, WhoAsksForPatienceWithoutEndIsGivenUp) {
  HostileServer server([](HostileServer::Stream&, int) {
    google::rpc::RetryInfo info;
    info.mutable_retry_delay()->set_seconds(INT64_MAX);
    google::rpc::Status status = ToProto(absl::ResourceExhaustedError("come back later"));
    status.add_details()->PackFrom(info);
    return grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED, "come back later",
                        status.SerializeAsString());
  });
  const auto engine = Connect(server, 10);
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(engine->Snapshot("studio").status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_LT(std::chrono::steady_clock::now() - start, seconds(8));
  EXPECT_EQ(events().back(), ConnectionEvent::Kind::kGivenUp);
  EXPECT_EQ(server.sessions(), 1);
}

// gRPC itself ends a call so whose message is too large for the other side: the next one would be
// too, and after a welcome there is all the time to try in again.
TEST_F(HostileServerTest, WhatNeverPassesIsNotTriedAgain) {
  HostileServer server([](HostileServer::Stream&, int) {
    return grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED,
                        "Received message larger than max (5000000 vs. 4194304)");
  });
  const auto engine = Connect(server, 10);
  const absl::Status status = engine->Snapshot("studio").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
  EXPECT_EQ(server.sessions(), 1);
  EXPECT_THAT(events(), ::testing::IsEmpty());
}

TEST_F(HostileServerTest, WhoeverWasTooSlowGoesOn) {
  HostileServer server([](HostileServer::Stream& stream, int session) {
    if (session > 1) return Listen(stream);
    return ToGrpcStatus(FieldError(absl::StatusCode::kResourceExhausted, "SLOW_CONSUMER", "",
                                   "found nothing taken for 30 s"));
  });
  const auto engine = Connect(server, 10);
  ASSERT_EQ(engine->ReportView("studio", "", std::nullopt), absl::OkStatus());
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (events().size() < 2 && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_THAT(events(), ::testing::ElementsAre(ConnectionEvent::Kind::kLost,
                                               ConnectionEvent::Kind::kRestored));
}

// Its stream may not have come to its end yet.
TEST_F(HostileServerTest, AViewIsNotReportedToASessionThatIsBeingEnded) {
  HostileServer server([](HostileServer::Stream& stream, int) { return Listen(stream); });
  const auto connection = ServerConnection::Open({.address = server.address()}).value();
  const auto session = SceneSession::Open(*connection, "studio").value();
  EXPECT_EQ(session->ReportView(std::nullopt), absl::OkStatus());
  session->End(absl::NotFoundError("the scene was deleted"));
  EXPECT_EQ(session->ReportView(std::nullopt).code(), absl::StatusCode::kNotFound);
}

TEST_F(HostileServerTest, AChangeWhoseEndNeverComesEndsTheMirror) {
  HostileServer server([](HostileServer::Stream& stream, int) {
    v1::SessionResponse response;
    v1::SceneUpdate& update = *response.mutable_scene_update();
    update.set_is_snapshot(true);
    update.set_is_continued(true);
    const std::string id(1, 'a');
    for (int i = 0; i < 20'000; ++i) *update.mutable_delta()->add_remove_instances() = id;
    for (int i = 0; i < 10 && stream.Write(response); ++i) {
    }
    return Listen(stream);
  });
  const auto engine = Connect(server, 0);
  const auto scene = engine->Snapshot("studio");
  EXPECT_EQ(scene.status().code(), absl::StatusCode::kDataLoss) << scene.status();
  EXPECT_THAT(std::string(scene.status().message()), HasSubstr("more than a scene may hold"));
}

// Whose scenes are small.
class SmallScenesServer final : public HostileServer {
 public:
  using HostileServer::HostileServer;

  grpc::Status GetServerInfo(grpc::ServerContext*, const v1::GetServerInfoRequest*,
                             v1::GetServerInfoResponse* response) override {
    SceneLimits limits;
    limits.max_instances = 4;
    limits.max_lights = limits.max_receivers = 1;
    limits.max_id_bytes = 8;
    limits.max_polygon_vertices = 3;
    WriteSceneLimits(limits, *response->mutable_limits());
    return grpc::Status::OK;
  }
};

// A few objects, of more bytes than any have.
TEST_F(HostileServerTest, AChangeOfTooManyBytesEndsTheMirror) {
  SmallScenesServer server([](HostileServer::Stream& stream, int) {
    v1::SessionResponse response;
    v1::SceneUpdate& update = *response.mutable_scene_update();
    update.set_is_snapshot(true);
    update.set_is_continued(true);
    update.mutable_delta()->add_remove_instances(std::string(2'000, 'a'));
    for (int i = 0; i < 4 && stream.Write(response); ++i) {
    }
    return Listen(stream);
  });
  const auto engine = Connect(server, 0);
  const auto scene = engine->Snapshot("studio");
  EXPECT_EQ(scene.status().code(), absl::StatusCode::kDataLoss) << scene.status();
  EXPECT_THAT(std::string(scene.status().message()), HasSubstr("more than a scene may hold"));
}

// A newer server may say more than this client knows of.
TEST_F(HostileServerTest, WhatNobodyKnowsIsNoPartOfAChange) {
  SmallScenesServer server([](HostileServer::Stream& stream, int) {
    v1::SessionResponse response;
    v1::SceneUpdate& update = *response.mutable_scene_update();
    update.set_is_snapshot(true);
    update.set_is_continued(true);
    update.set_content_hash(ToProto(Scene::Empty("studio")->content_hash()));
    v1::SceneDelta& delta = *update.mutable_delta();
    delta.GetReflection()->MutableUnknownFields(&delta)->AddLengthDelimited(
        1'000, std::string(2'000, 'a'));
    for (int i = 0; i < 8 && stream.Write(response); ++i) {
    }
    update.set_is_continued(false);
    stream.Write(response);
    return Listen(stream);
  });
  const auto engine = Connect(server, 0);
  const auto scene = engine->Snapshot("studio");
  ASSERT_EQ(scene.status(), absl::OkStatus());
  EXPECT_TRUE((*scene)->instances().empty());
}

TEST_F(HostileServerTest, ACrowdThatNoSceneHoldsEndsTheSession) {
  HostileServer server([](HostileServer::Stream& stream, int) {
    v1::SessionResponse response;
    response.mutable_presence_update()->set_is_everything(true);
    for (int i = 0; i < 5'000; ++i) {
      response.mutable_presence_update()->add_participants()->set_participant_id(std::to_string(i));
    }
    stream.Write(response);
    return Listen(stream);
  });
  const auto engine = Connect(server, 0);
  const auto me = engine->Enter("studio", {.display_name = "Ada"}, nullptr);
  EXPECT_EQ(me.status().code(), absl::StatusCode::kDataLoss) << me.status();
  EXPECT_THAT(std::string(me.status().message()), HasSubstr("participants"));
}

}  // namespace
}  // namespace penumbra::testing
