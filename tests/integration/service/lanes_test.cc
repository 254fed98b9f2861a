// What takes long, and what must not wait for it: commits, for nothing but commits.

#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <latch>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "proto/convert/scene_convert.h"
#include "render/engine/local_engine.h"
#include "server/scene_store/scene_store.h"
#include "tests/integration/service/durable_scenes.h"
#include "tests/integration/service/import_call.h"
#include "tests/support/faulty_vfs.h"
#include "tests/support/stalled_file.h"

namespace penumbra::testing {
namespace {

// As many as can keep every thread of a lane busy.
constexpr int kMany = 20;
constexpr std::chrono::seconds kSoon{10};

class LanesTest : public DurableScenesTest {
 protected:
  LanesTest() { options_.storage.database.vfs = disk_.name(); }
  ~LanesTest() override {
    disk_.Heal();
    session_.reset();
    client_.reset();
    server_.reset();  // before the disk that it writes to
  }
  static v1::SessionRequest Commit(const SceneDelta& delta) {
    v1::SessionRequest request;
    request.mutable_commit()->set_commit_id(100);
    *request.mutable_commit()->mutable_delta() = ToProto(delta);
    return request;
  }

  FaultyVfs disk_;
};

TEST_F(LanesTest, ScenesThatWaitToBeMadeHoldUpNoCommit) {
  Restart();
  MakeStudio();
  StalledFile stalled(folder_ / "data/owners.new");
  std::vector<std::future<absl::Status>> creating;
  for (int i = 0; i < kMany; ++i) {
    creating.push_back(std::async(std::launch::async, [this, i] {
      return client_->CreateScene("waits-" + std::to_string(i));
    }));
  }
  std::this_thread::sleep_for(std::chrono::seconds(1));  // until they have all the threads they get
  auto commit = std::async(std::launch::async, [&] {
    return session_->Commit(MoveBox({1, 1, 0}));
  });
  EXPECT_EQ(commit.wait_for(kSoon), std::future_status::ready);
  stalled.WakeUp();
  EXPECT_EQ(commit.get().revision(), 2u);
  int failed = 0;
  for (auto& one : creating) failed += one.get().ok() ? 0 : 1;
  EXPECT_EQ(failed, 1) << "whose owner could not be written down";
}

TEST_F(LanesTest, AnImportThatWaitsHoldsUpNoUploadAndNoExport) {
  Restart();
  MakeStudio();
  StalledFile stalled(folder_ / "data/owners.new");
  ImportCall import(*client_);
  ASSERT_TRUE(import.Send("imported", {}));
  std::this_thread::sleep_for(std::chrono::seconds(1));  // until it waits
  auto upload = std::async(std::launch::async,
                           [&] { return client_->Upload(*MeshOf(UnitSquareGeometry())); });
  auto exporting = std::async(std::launch::async, [&] {
    v1::ExportSceneRequest request;
    request.set_scene_id("studio");
    grpc::ClientContext context;
    const auto reader = client_->stub().ExportScene(&context, request);
    v1::ExportSceneResponse response;
    while (reader->Read(&response)) {
    }
    return FromGrpcStatus(reader->Finish());
  });
  EXPECT_EQ(upload.wait_for(kSoon), std::future_status::ready);
  EXPECT_EQ(exporting.wait_for(kSoon), std::future_status::ready);
  stalled.WakeUp();
  EXPECT_EQ(upload.get(), absl::OkStatus());
  EXPECT_EQ(exporting.get(), absl::OkStatus());
  EXPECT_FALSE(import.End().ok()) << "its owner could not be written down";
}

TEST_F(LanesTest, AResumeWaitsForNoCommit) {
  options_.limits.max_commit_delay_ms = 60'000;
  Restart();
  MakeStudio();
  const std::string incarnation = WireSession(client_->stub()).Hello("studio").incarnation();
  const auto known = session_->Commit(MoveBox({1, 1, 0}));
  ASSERT_EQ(session_->Commit(MoveBox({2, 1, 0})).revision(), 3u);
  // Until its file has all of it, so that reading it writes nothing.
  std::this_thread::sleep_for(std::chrono::milliseconds(2'500));
  std::vector<std::unique_ptr<WireSession>> others;
  for (int i = 0; i < kMany; ++i) {
    const std::string id = "other-" + std::to_string(i);
    ASSERT_EQ(client_->CreateScene(id), absl::OkStatus());
    others.push_back(client_->OpenSession(id));
  }
  disk_.Stall();
  for (const auto& other : others) other->Send(Commit(MoveBox({0, 1, 0})));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));  // until no writer is free
  auto resumed = std::async(std::launch::async, [&] {
    return WireSession(client_->stub())
        .Resume("studio", incarnation, known.revision(), known.content_hash());
  });
  EXPECT_EQ(resumed.wait_for(kSoon), std::future_status::ready);
  disk_.Heal();
  EXPECT_TRUE(resumed.get().is_resumed());
  for (const auto& other : others) {
    const auto answer = other->ReadUntil(v1::SessionResponse::kCommitResult);
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->commit_result().revision(), 1u);
  }
}

TEST_F(LanesTest, HistoriesThatAreReadHoldUpNoCommit) {
  const auto storage = SceneStorage::Open(folder_ / "data", {}, logger_).value();
  const ServerLimits limits{};
  ServerCounters counters;
  LocalEngine engine{{.cpu_threads = 1}};
  BlobStore blobs{limits};
  blobs.KeepOn(storage->blob_files());
  SceneStore scenes(engine, blobs, limits, counters, storage.get());
  ASSERT_TRUE(scenes.Create("studio").ok());
  std::latch may_go_on(1);
  for (int i = 0; i < kMany; ++i) {
    storage->history_lane().Post("eve", [&] { may_go_on.wait(); });
    storage->scenes_lane().Post("eve", [&] { may_go_on.wait(); });
  }
  std::promise<absl::Status> answer;
  scenes.Commit("studio", {.delta = SceneDelta{.upsert_lights = {SquareLight()}}}, {},
                [&](const auto& outcome) { answer.set_value(outcome.status()); });
  auto answered = answer.get_future();
  EXPECT_EQ(answered.wait_for(kSoon), std::future_status::ready);
  may_go_on.count_down();
  EXPECT_EQ(answered.get(), absl::OkStatus());
  storage->Stop();
}

}  // namespace
}  // namespace penumbra::testing
