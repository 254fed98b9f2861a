// Scenes that change, go or lose their file while they are exported.
#include "server/scene_store/scene_export.h"

#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <memory>
#include <string>
#include <utility>

#include "proto/archive/archive_order.h"
#include "render/engine/local_engine.h"
#include "render/scene/field_error.h"
#include "server/scene_store/scene_archives.h"
#include "tests/integration/service/kept_log.h"
#include "tests/integration/service/studio.h"
#include "tests/support/faulty_vfs.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

class Storehouse {
 public:
  // Without a `disk` scenes live in memory.
  explicit Storehouse(FaultyVfs* disk) {
    if (disk) {
      storage_ =
          SceneStorage::Open(folder_ / "data", {.database = {.vfs = disk->name()}}, log_).value();
      blobs_.KeepOn(storage_->blob_files());
      scenes_ = std::make_unique<SceneStore>(engine_, blobs_, limits_, counters_, storage_.get());
    } else {
      scenes_ = std::make_unique<SceneStore>(engine_, blobs_, limits_, counters_, nullptr);
    }
    archives_ = std::make_unique<SceneArchives>(*scenes_);
    EXPECT_TRUE(scenes().Create("studio").ok());
    SceneDelta delta = StudioDelta();
    delta.upsert_instances[0].mesh = StoredBox();
    EXPECT_EQ(Commit(std::move(delta)), absl::OkStatus());
  }
  ~Storehouse() {
    if (storage_) storage_->Stop();
  }

  absl::Status Commit(SceneDelta delta) {
    std::promise<absl::Status> answer;
    scenes().Commit("studio", {.delta = std::move(delta)}, {},
                    [&](const auto& outcome) { answer.set_value(outcome.status()); });
    return answer.get_future().get();
  }
  // With the head alone sent.
  std::unique_ptr<SceneExport> Begin(bool with_history) {
    auto exported = archives_->Export("studio", with_history);
    EXPECT_TRUE(exported.ok()) << exported.status();
    v1::ExportSceneResponse message;
    for (; message.records().empty(); ++pieces_) EXPECT_TRUE((*exported)->Next(message).value());
    EXPECT_EQ(message.records_size(), 1);
    EXPECT_EQ(order_.Take(message.records(0)).status(), absl::OkStatus());
    return *std::move(exported);
  }
  absl::Status SendRest(SceneExport& exported) {
    for (;;) {
      v1::ExportSceneResponse message;
      const auto is_there_more = exported.Next(message);
      if (!is_there_more.ok()) return is_there_more.status();
      for (const auto& record : message.records()) {
        if (auto status = order_.Take(record).status(); !status.ok()) return status;
      }
      if (!*is_there_more) return absl::OkStatus();
    }
  }
  bool is_whole() const { return order_.has_ended(); }
  // That the history was looked through in.
  int pieces() const { return pieces_; }
  SceneStore& scenes() { return *scenes_; }

 private:
  std::shared_ptr<const Mesh> StoredBox() {
    const auto blob = EncodeBlob(BoxMesh()->geometry());
    auto upload = blobs_.Begin(BoxMesh()->id(), blob.size()).value();
    EXPECT_EQ(upload->Append({reinterpret_cast<const char*>(blob.data()), blob.size()}),
              absl::OkStatus());
    EXPECT_TRUE(upload->Finish().ok());
    return blobs_.FindMesh(BoxMesh()->id());
  }

  const TemporaryFolder folder_;
  KeptLog log_;
  const ServerLimits limits_{.max_message_bytes = 1'100};  // a record a message
  ServerCounters counters_;
  std::unique_ptr<SceneStorage> storage_;
  LocalEngine engine_{{.cpu_threads = 1}};
  BlobStore blobs_{limits_};
  std::unique_ptr<SceneStore> scenes_;
  std::unique_ptr<SceneArchives> archives_;
  ArchiveOrder order_{ArchiveOrderOptions()};
  int pieces_ = 0;
};

TEST(SceneExportTest, WhatASceneNoLongerNamesIsExportedToTheEnd) {
  Storehouse store(nullptr);
  const auto exported = store.Begin(/*with_history=*/false);
  SceneDelta removal;
  removal.remove_instances = {"box"};
  ASSERT_EQ(store.Commit(removal), absl::OkStatus());
  ASSERT_EQ(store.scenes().CollectBlobs(std::chrono::seconds(0)), absl::OkStatus());
  EXPECT_EQ(store.SendRest(*exported), absl::OkStatus());
  EXPECT_TRUE(store.is_whole());
}

// So that other exports and imports have their turn between two pieces.
TEST(SceneExportTest, ALongHistoryIsLookedThroughAPieceAtATime) {
  FaultyVfs disk;
  Storehouse store(&disk);
  SceneDelta lamps;
  for (int i = 0; i < 1'000; ++i) {
    lamps.upsert_lights.push_back({.id = "lamp-" + std::to_string(i), .shape = PointLight()});
  }
  for (int i = 0; i < 160; ++i) ASSERT_EQ(store.Commit(lamps), absl::OkStatus());
  const auto exported = store.Begin(/*with_history=*/true);
  EXPECT_GE(store.pieces(), 3) << "of a mebibyte";
  EXPECT_EQ(store.SendRest(*exported), absl::OkStatus());
  EXPECT_TRUE(store.is_whole());
}

TEST(SceneExportTest, ASceneThatIsDeletedIsNotFound) {
  FaultyVfs disk;
  Storehouse store(&disk);
  const auto exported = store.Begin(/*with_history=*/true);
  ASSERT_EQ(store.scenes().Delete("studio"), absl::OkStatus());
  const absl::Status end = store.SendRest(*exported);
  EXPECT_EQ(end.code(), absl::StatusCode::kNotFound) << end;
  EXPECT_EQ(ErrorReason(end), "UNKNOWN_ID");
}

TEST(SceneExportTest, AHistoryThatIsBegunAnewIsToBeExportedAgain) {
  FaultyVfs disk;
  Storehouse store(&disk);
  const auto exported = store.Begin(/*with_history=*/true);
  disk.FailAfter(0, FaultyVfs::Call::kSync, SQLITE_IOERR_FSYNC);
  ASSERT_EQ(store.Commit(MoveBox({1, 1, 0})).code(), absl::StatusCode::kUnavailable);
  disk.Heal();
  ASSERT_EQ(store.Commit(MoveBox({1, 1, 0})), absl::OkStatus());
  EXPECT_EQ(store.SendRest(*exported).code(), absl::StatusCode::kAborted);
}

}  // namespace
}  // namespace penumbra::testing
