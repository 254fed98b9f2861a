// Scenes and blobs on disk, for a server that keeps them there.
//
//   auto storage = SceneStorage::Open(folder, {}, logger);
//   for (RestoredScene& restored : (*storage)->Restore(blobs, limits)) …
//   auto log = (*storage)->Create("studio");
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "render/engine/worker_pool.h"
#include "server/log/logger.h"
#include "server/scene_store/blob_store.h"
#include "server/scene_store/scene_log.h"
#include "server/storage/blob_files.h"
#include "server/storage/data_directory.h"
#include "server/storage/heads_file.h"

namespace penumbra {

// A scene that a server finds when it starts.
struct RestoredScene {
  std::string scene_id;
  absl::Status status;  // why it cannot be served; then there is none of the rest
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<SceneLog> log;
  std::vector<CommitRecord> answers;  // commits with a key, oldest first
};

class SceneStorage {
 public:
  // Errors  those of DataDirectory
  static absl::StatusOr<std::unique_ptr<SceneStorage>> Open(const std::string& folder,
                                                            const SceneLogOptions& options,
                                                            Logger& logger);
  ~SceneStorage();
  // Waits for the tasks that run, and drops those that do not yet.
  void Stop() { workers_.Stop(); }

  BlobFiles& blob_files() { return blob_files_; }
  // For what waits for the disk: several tasks at a time.
  WorkerPool::Lane& lane() { return workers_.lane(0); }

  // Every scene that there is, or that there was and ought to be; their blobs are put into `blobs`.
  // Scenes that are damaged stay as they are. To be called once, first.
  std::vector<RestoredScene> Restore(BlobStore& blobs, const SceneLimits& limits);

  // Both return once that is on disk. Errors  those of SceneFile
  absl::StatusOr<std::shared_ptr<SceneLog>> Create(const std::string& scene_id);
  absl::Status Remove(SceneLog& log);
  // Of a scene that cannot be served: its file is moved aside.
  absl::Status PutAside(const std::string& scene_id);

  // What is done now and then, on a thread of the lane's, until Stop.
  void KeepHouse(std::function<void()> housekeeping);

  // The scene has come so far. Written down within a second.
  void Note(const SceneLog& log, Revision revision);

 private:
  SceneStorage(std::unique_ptr<DataDirectory> directory, const SceneLogOptions& options,
               Logger& logger);
  RestoredScene RestoreScene(const std::string& scene_id, uint64_t number, BlobStore& blobs,
                             const SceneLimits& limits);
  absl::Status CheckAgainstHeads(const SceneFile& file) const;
  absl::Status ReadHeadsFile();
  absl::Status WriteHeadsNow();
  void WriteHeadsLater();

  const std::unique_ptr<DataDirectory> directory_;
  const SceneLogOptions options_;
  Logger& logger_;
  BlobFiles blob_files_;

  std::mutex writing_;  // held while the heads are written; taken before mutex_
  std::mutex mutex_;    // guards the rest
  std::condition_variable noted_;
  KnownHeads heads_;
  bool are_heads_new_ = false;
  bool is_ending_ = false;
  std::function<void()> housekeeping_;  // null: none

  WorkerPool workers_;
  std::thread heads_writer_;
};

}  // namespace penumbra
