// Mirrors: what other clients do to the scene, however much of it there is and however long it
// takes to fetch.
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <memory>
#include <string>
#include <thread>

#include "penumbra/v1/service.grpc.pb.h"
#include "proto/convert/scene_convert.h"
#include "proto/convert/status_convert.h"
#include "tests/integration/session/remote_engine_fixture.h"
#include "tests/support/hostile_server.h"

namespace penumbra::testing {
namespace {

using std::chrono::milliseconds, std::chrono::seconds;

Instance Square(const std::string& id, Vec3 position) {
  static const auto square = MeshOf(UnitSquareGeometry());
  return {.id = id, .mesh = square, .world_from_mesh = Placed(position)};
}

TEST_F(RemoteEngineTest, AChangeInPiecesIsAppliedAsOne) {
  ServerLimits limits;
  limits.max_message_bytes = 16 << 10;
  server_ =
      PenumbraServer::Start({.listen = "127.0.0.1:0", .opens_gl = false, .limits = limits}).value();
  const auto alice = Connect();
  const auto bob = Connect();
  ASSERT_EQ(alice->CreateScene("studio"), absl::OkStatus());
  SceneDelta delta;
  delta.upsert_instances = {Square("a", {0, 0, 0}), Square("b", {2, 0, 0})};
  delta.upsert_receivers = {{.id = "r", .shape = PlanarInstance{"a"}}};
  ASSERT_TRUE(alice->Commit("studio", delta).ok());
  ASSERT_EQ(bob->Snapshot("studio").value()->revision(), 1u);

  // The receiver moves to "b" in the last piece, "a" goes in the first.
  delta.upsert_instances.clear();
  delta.remove_instances = {"a"};
  delta.upsert_receivers = {{.id = "r", .shape = PlanarInstance{"b"}}};
  constexpr size_t kAlmostAMessage = (16 << 10) - 200;
  for (int i = 0; ToProto(delta).ByteSizeLong() < kAlmostAMessage; ++i) {
    delta.upsert_instances.push_back(Square(std::to_string(i), {0, 1, 0}));
  }
  ASSERT_GT(ToProtoPieces(delta, limits.max_message_bytes - 128).size(), 1u);
  const auto revision = alice->Commit("studio", delta);
  ASSERT_TRUE(revision.ok()) << revision.status();
  const auto hash = alice->Snapshot("studio").value()->content_hash();

  const auto end = std::chrono::steady_clock::now() + kPatience;
  absl::StatusOr<std::shared_ptr<const Scene>> mirrored;
  do {
    mirrored = bob->Snapshot("studio");
    ASSERT_TRUE(mirrored.ok()) << mirrored.status();
  } while ((*mirrored)->revision() < 2 && std::chrono::steady_clock::now() < end);
  EXPECT_EQ((*mirrored)->revision(), 2u);
  EXPECT_EQ((*mirrored)->content_hash(), hash);
}

// Tells of a mesh that nobody can fetch, and goes on.
class StuckServer final : public HostileServer {
 public:
  StuckServer() : HostileServer([](Stream& stream, int) { return Listen(stream); }) {}
  ~StuckServer() override { Shutdown(); }

  bool is_downloading() const { return is_downloading_; }

  // Of a scene that is not there any more nobody is welcomed.
  grpc::Status Session(grpc::ServerContext*, Stream* stream) override {
    v1::SessionRequest request;
    while (stream->Read(&request)) {
      if (request.has_hello()) {
        if (is_deleted_) return grpc::Status(grpc::StatusCode::NOT_FOUND, "no such scene");
        Welcome(*stream);
      }
      if (request.has_commit()) {
        v1::SessionResponse response;
        response.mutable_commit_result()->set_commit_id(request.commit().commit_id());
        response.mutable_commit_result()->set_revision(5);
        stream->Write(response);
      }
      if (request.has_subscribe()) Update(*stream, request.subscribe().subscription_id());
      if (request.has_subscribe_each()) {
        ManySubscriptions(*stream, request.subscribe_each().first_subscription_id());
      }
    }
    return grpc::Status::OK;
  }

  grpc::Status DeleteScene(grpc::ServerContext*, const v1::DeleteSceneRequest*,
                           v1::DeleteSceneResponse*) override {
    is_deleted_ = true;
    return grpc::Status::OK;
  }

  // Until it is cancelled, or the test has failed anyway.
  grpc::Status DownloadBlob(grpc::ServerContext* context, const v1::DownloadBlobRequest*,
                            grpc::ServerWriter<v1::DownloadBlobResponse>*) override {
    is_downloading_ = true;
    for (int i = 0; i < 2500 && !context->IsCancelled(); ++i) {
      std::this_thread::sleep_for(milliseconds(10));
    }
    return grpc::Status::CANCELLED;
  }

 private:
  static void Welcome(Stream& stream) {
    v1::SessionResponse welcome;
    welcome.mutable_welcome()->set_protocol_version(1);
    stream.Write(welcome);
    for (uint64_t revision = 1; revision <= 4; ++revision) {
      v1::SessionResponse response;
      v1::SceneUpdate& update = *response.mutable_scene_update();
      update.set_is_snapshot(revision == 1);
      update.set_from_revision(revision - 1);
      update.set_revision(revision);
      update.mutable_delta()->add_upsert_instances()->set_mesh_hash(std::string(32, 'x'));
      stream.Write(response);
    }
  }
  static void Update(Stream& stream, uint64_t subscription_id) {
    v1::SessionResponse response;
    response.mutable_subscribe_result()->set_subscription_id(subscription_id);
    stream.Write(response);
    v1::ArtifactUpdate& update = *response.mutable_artifact_update();
    update.set_subscription_id(subscription_id);
    update.set_revision(4);
    update.set_end_of_update(true);
    *update.mutable_error() = ToProto(absl::FailedPreconditionError("no light"));
    stream.Write(response);
  }

  static void ManySubscriptions(Stream& stream, uint64_t first_id) {
    v1::SessionResponse response;
    v1::SubscribeEachResult& result = *response.mutable_subscribe_each_result();
    result.set_first_subscription_id(first_id);
    // Not from a literal, of which g++ 12 takes the length for endless when it has inlined enough.
    const std::string light(1, 'l'), receiver(1, 'r');
    for (int i = 0; i < 100'000; ++i) {
      *result.add_light_ids() = light;
      *result.add_receiver_ids() = receiver;
    }
    stream.Write(response);
  }

  std::atomic<bool> is_downloading_{false};
  std::atomic<bool> is_deleted_{false};
};

TEST(StuckMirrorTest, KeepsNeitherCallbacksNorCommitsNorTheEndWaiting) {
  StuckServer server;
  auto engine = RemoteEngine::Connect({.address = server.address()}).value();
  Inbox inbox;
  auto subscription = engine->Subscribe("studio", FloorSpec(), inbox.callback());
  ASSERT_TRUE(subscription.ok()) << subscription.status();
  const auto start = std::chrono::steady_clock::now();
  EXPECT_TRUE(inbox.WaitForError(absl::StatusCode::kFailedPrecondition));
  while (!server.is_downloading() && std::chrono::steady_clock::now() < start + kPatience) {
    std::this_thread::sleep_for(milliseconds(5));
  }
  const auto revision = engine->Commit("studio", {});
  ASSERT_TRUE(revision.ok()) << revision.status();
  EXPECT_EQ(*revision, 5u);

  // Somebody who does wait for the mirror is told when it ends.
  auto waiting =
      std::async(std::launch::async, [&] { return engine->Snapshot("studio").status(); });
  std::this_thread::sleep_for(milliseconds(50));
  EXPECT_EQ(engine->DeleteScene("studio"), absl::OkStatus());
  EXPECT_EQ(waiting.get().code(), absl::StatusCode::kNotFound);
  engine.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - start, seconds(10));
}

// A message of 600 KB that stands for 10 billion subscriptions.
TEST(StuckMirrorTest, MoreSubscriptionsThanThereCanBeEndTheSession) {
  StuckServer server;
  const auto engine = RemoteEngine::Connect({.address = server.address()}).value();
  const auto all = engine->SubscribeEach("studio", {.params = SoftTextureParams{}},
                                         [](const auto&, const auto&, const auto&) {});
  EXPECT_EQ(all.status().code(), absl::StatusCode::kDataLoss) << all.status();
}

}  // namespace
}  // namespace penumbra::testing
