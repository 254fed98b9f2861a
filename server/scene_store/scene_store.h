// The scenes, the order of their commits, and who has to know of them.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "render/engine/local_engine.h"
#include "server/counters.h"
#include "server/fair_lane.h"
#include "server/limits.h"
#include "server/scene_store/blob_store.h"
#include "server/scene_store/commit_request.h"
#include "server/scene_store/scene_owners.h"
#include "server/scene_store/scene_storage.h"
#include "server/scene_store/storage_backlog.h"
#include "server/scene_store/write_queue.h"

namespace penumbra {

// Told of each commit to a scene, in their order, and of its end. Calls must not block.
class SceneWatcher {
 public:
  virtual ~SceneWatcher() = default;
  virtual void OnScene(std::shared_ptr<const Scene> scene) = 0;
  virtual void OnSceneDeleted(const absl::Status& reason) = 0;
};

struct WatchedScene {
  std::shared_ptr<const Scene> scene;
  std::string incarnation;  // 16 bytes, different for every scene ever made
};

// Any thread may use it. Where scenes are kept on disk, a commit is checked at once, and told to
// anybody only once it is there. Until then later ones build on it, and all are on their way.
class SceneStore {
 public:
  // `storage` is null where scenes live in memory only. All of it outlives the store.
  SceneStore(LocalEngine& engine, BlobStore& blobs, const ServerLimits& limits,
             ServerCounters& counters, SceneStorage* storage);
  ~SceneStore();

  // Takes in what was on disk. To be called once, first.
  void Restore();

  // These wait for the disk. Errors  those of Engine; of scenes that are damaged kDataLoss DAMAGED,
  // of those that cannot be read for now kResourceExhausted DISK_FULL, kUnavailable STORAGE_FAILED
  // Create, further: kResourceExhausted QUOTA_SCENES: the owner has as many as it may
  absl::StatusOr<SceneInfo> Create(const std::string& scene_id, const SceneOwner& owner = {});
  // After an error of the disk the scene is among those that are refused until it is deleted.
  absl::Status Delete(const std::string& scene_id);
  absl::StatusOr<std::vector<SceneInfo>> List() { return engine_.ListScenes(); }
  // Scenes that are on disk and cannot be served, with the reason. Those whose reason may pass are
  // looked at again every few seconds; until then errors of theirs have a retry delay.
  std::map<std::string, absl::Status> Refused() const;

  // The scene as it is; `watcher` hears of everything after that until it is gone.
  // Errors  kNotFound; kDataLoss DAMAGED
  absl::StatusOr<WatchedScene> Watch(const std::string& scene_id,
                                     std::weak_ptr<SceneWatcher> watcher);

  // How the first commit with this key was answered; none: there is none, or none on disk yet.
  // Errors  kNotFound; kInvalidArgument REQUEST_ID_REUSED, BAD_ID
  absl::StatusOr<std::optional<CommitOutcome>> FirstAnswer(const std::string& scene_id,
                                                           const std::string& idempotency_key,
                                                           const ContentHash& fingerprint);

  // Whether a commit with this key is in, or on its way to the disk.
  bool HasCommit(const std::string& scene_id, const std::string& idempotency_key) const;

  // Calls `done` once, before or after it returns, on any thread: then the commit is on disk and
  // watchers other than `author` have been told, or nothing has changed.
  // Errors  those of Engine::Commit; kInvalidArgument REQUEST_ID_REUSED, BAD_ID;
  //         kResourceExhausted QUOTA_PENDING, QUOTA_PENDING_BYTES: too many are on their way;
  //         OVERLOADED: those that are have been for too long; all three with a retry delay;
  //         DISK_FULL; kUnavailable STORAGE_FAILED
  void Commit(const std::string& scene_id, CommitRequest request,
              std::weak_ptr<const SceneWatcher> author, CommitCallback done);

  // The scene as it was. Waits for the disk.
  // Errors  kNotFound: no such scene, or another one now; kOutOfRange COMPACTED, FUTURE_BASE
  absl::StatusOr<std::shared_ptr<const Scene>> SceneAt(const std::string& scene_id,
                                                       const std::string& incarnation,
                                                       Revision revision);

  // Errors  those of Engine::ReportView
  absl::Status ReportView(const std::string& scene_id, const std::string& viewer,
                          const std::optional<View>& view) {
    return engine_.ReportView(scene_id, viewer, view);
  }

  // What the scene is now. Errors  kNotFound
  absl::StatusOr<std::shared_ptr<const Scene>> Snapshot(const std::string& scene_id) {
    return engine_.Snapshot(scene_id);
  }

  // Drops blobs that no scene needs any more. Waits for the disk.
  absl::Status CollectBlobs(std::chrono::seconds age);

  // Where histories are read, and scenes made and deleted; null where nothing waits for a disk.
  FairLane* history_lane() { return storage_ ? &storage_->history_lane() : nullptr; }
  FairLane* scenes_lane() { return storage_ ? &storage_->scenes_lane() : nullptr; }

 private:
  friend class SceneArchives;
  struct Entry;
  struct Pending;
  struct JournalPart;
  // Why a scene that is on disk cannot be served.
  struct Refusal {
    absl::Status status;
    bool is_for_now = false;  // it may be again, and nothing of it is damaged
  };
  using Batch = std::vector<std::shared_ptr<Pending>>;
  using Recalled = absl::StatusOr<std::optional<CommitOutcome>>;

  absl::StatusOr<std::shared_ptr<Entry>> Find(const std::string& scene_id) const;
  absl::StatusOr<SceneInfo> CreateReserved(const std::string& scene_id);
  void AttributeBlobs(const Scene& scene);
  void TakeIn(RestoredScene restored);
  void RestoreAgain();
  absl::Status DeleteReserved(const std::string& scene_id);
  absl::Status DeleteRefused(const std::string& scene_id);
  // With the entry's mutex locked, as for the next seven.
  Recalled Recall(const Entry& entry, const std::string& key, const ContentHash& fingerprint) const;
  void Remember(Entry& entry, const CommitRecord& answer);
  absl::StatusOr<CommitOutcome> Prepare(Entry& entry, Pending& pending) const;
  absl::Status Admit(const Entry& entry, const CommitRequest& request) const;
  void Send(const std::shared_ptr<Entry>& entry, std::shared_ptr<Pending> pending);
  void PostWrite(const std::shared_ptr<Entry>& entry);
  absl::StatusOr<CommitOutcome> Publish(Entry& entry, const Pending& pending);
  void WritePending(const std::shared_ptr<Entry>& entry);
  void WriteTogether();
  void ConcludePart(JournalPart& part, const absl::Status& written);
  void GoOn(const std::shared_ptr<Entry>& entry);
  void Conclude(Entry& entry, const Batch& batch, const absl::Status& written);

  LocalEngine& engine_;
  BlobStore& blobs_;
  const ServerLimits limits_;
  ServerCounters& counters_;
  SceneStorage* const storage_;
  StorageBacklog backlog_;
  SceneOwners owners_;
  WriteQueue<std::shared_ptr<Entry>> for_journal_;  // those whose commits may go there
  std::atomic<bool> is_tidying_ = false;            // one whose commits do

  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<Entry>> entries_;
  std::map<std::string, Refusal> refused_;
  std::set<std::string> changing_;  // ids of scenes that are being created or deleted
};

}  // namespace penumbra
