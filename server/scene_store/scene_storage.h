// Scenes and blobs on disk, for a server that keeps them there.
//
//   auto storage = SceneStorage::Open(folder, {}, logger);
//   for (RestoredScene& restored : (*storage)->Restore(blobs, limits)) …
//   auto log = (*storage)->Create("studio");
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "render/engine/worker_pool.h"
#include "server/fair_lane.h"
#include "server/log/logger.h"
#include "server/scene_store/blob_store.h"
#include "server/scene_store/found_journals.h"
#include "server/scene_store/imported_file.h"
#include "server/scene_store/scene_log.h"
#include "server/scene_store/shared_journal.h"
#include "server/storage/blob_files.h"
#include "server/storage/data_directory.h"
#include "server/storage/heads_file.h"

namespace penumbra {

// A scene that a server finds when it starts.
struct RestoredScene {
  std::string scene_id;
  absl::Status status;  // why it cannot be served; then there is the next, and none of the rest
  JournalNeed need;
  // It is no damage that keeps it from being served: a full disk, for instance.
  bool is_for_now() const {
    return absl::IsUnavailable(status) || absl::IsResourceExhausted(status);
  }
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
  void Stop();

  BlobFiles& blob_files() { return blob_files_; }
  std::string owners_path() const { return directory_->owners_path(); }
  std::string results_path() const { return directory_->results_path(); }
  const SceneLogOptions& options() const { return options_; }
  Logger& logger() { return logger_; }
  // For commits on their way to the disk: several at a time.
  WorkerPool::Lane& lane() { return workers_.lane(0); }
  // For what may take long, and no commit waits for: reading histories; making and deleting scenes.
  FairLane& history_lane() { return history_lane_; }
  FairLane& scenes_lane() { return scenes_lane_; }

  // Every scene that there is, or that there was and ought to be; their blobs are put into `blobs`.
  // Scenes that are damaged stay as they are. To be called once, first.
  std::vector<RestoredScene> Restore(BlobStore& blobs, const SceneLimits& limits);

  // These scenes, that could not be read for now, as they are now. Nobody else changes them
  // meanwhile.
  std::vector<RestoredScene> RestoreAgain(const std::vector<std::string>& scene_ids,
                                          BlobStore& blobs, const SceneLimits& limits);

  // Both return once that is on disk. Errors  those of SceneFile
  absl::StatusOr<std::shared_ptr<SceneLog>> Create(const std::string& scene_id);
  absl::Status Remove(SceneLog& log);
  // A scene that is not there before Adopt, and wholly there after it.
  absl::StatusOr<std::unique_ptr<ImportedFile>> BeginImport(const std::string& scene_id,
                                                            const SceneState& start);
  absl::StatusOr<std::shared_ptr<SceneLog>> Adopt(ImportedFile& imported);
  // Of a scene that cannot be served: its file is moved aside, with the journals that it needs.
  absl::Status PutAside(const std::string& scene_id);

  // What is done now and then, on the lane for histories, until Stop. Once at a time.
  void KeepHouse(std::chrono::seconds interval, std::function<void()> chore);

  // Commits of several scenes at a time go there.
  SharedJournal& journals() { return journals_; }

  // The scene has come so far. Written down within a second.
  void Note(const SceneLog& log, Revision revision);

 private:
  struct Chore {
    std::chrono::seconds interval;
    std::function<void()> task;
    std::chrono::steady_clock::time_point begun = std::chrono::steady_clock::now();
    bool is_under_way = false;
  };

  SceneStorage(std::unique_ptr<DataDirectory> directory, const SceneLogOptions& options,
               Logger& logger);
  FoundJournals ReadJournals();
  void RemoveJournals(const FoundJournals& journals, const std::vector<RestoredScene>& restored);
  RestoredScene RestoreScene(const std::string& scene_id, uint64_t number,
                             const FoundJournals& journals, BlobStore& blobs,
                             const SceneLimits& limits);
  JournalNeed NeedOf(const std::string& scene_id, const std::string& path, const SceneFile* file);
  std::optional<KnownHead> Known(const std::string& scene_id);
  static absl::Status MakeLast(SceneFile& file, const std::vector<CommitRecord>& newer);
  absl::Status CheckAgainstHeads(const SceneIdentity& identity, Revision revision);
  void Tell(const std::vector<RestoredScene>& restored, bool again = false);
  absl::StatusOr<std::vector<uint64_t>> KeptJournals(const std::string& scene_id);
  std::shared_ptr<SceneLog> Log(std::unique_ptr<SceneFile> file);
  absl::Status ReadHeadsFile();
  absl::Status WriteHeadsNow();
  void WriteHeadsLater();
  void RestLogs();
  void PostChores();
  void Do(Chore& chore);

  const std::unique_ptr<DataDirectory> directory_;
  const SceneLogOptions options_;
  Logger& logger_;
  BlobFiles blob_files_;
  SharedJournal journals_;

  std::mutex writing_;  // held while the heads are written; taken before mutex_
  std::mutex mutex_;    // guards the rest
  std::condition_variable noted_;
  KnownHeads heads_;
  bool are_journals_known_ = false;  // once Restore has looked at all scenes and journals
  std::map<std::string, std::vector<uint64_t>> kept_journals_;  // of refused scenes, by id
  bool are_heads_new_ = false;
  bool is_ending_ = false;
  std::deque<Chore> chores_;  // stay where they are
  std::vector<std::weak_ptr<SceneLog>> logs_;
  bool are_logs_resting_ = false;  // a task is going to see to them, or does

  WorkerPool workers_;
  FairLane history_lane_, scenes_lane_;
  std::thread heads_writer_;
};

}  // namespace penumbra
