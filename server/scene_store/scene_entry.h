// What a store knows of one scene. For the files of scene_store only.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "server/scene_store/scene_store.h"

namespace penumbra {

// A commit on its way to the disk.
struct SceneStore::Pending {
  CommitRequest request;
  std::weak_ptr<const SceneWatcher> author;
  std::shared_ptr<const Scene> before;
  std::shared_ptr<const Scene> after;
  int64_t time_ms = 0;
  StorageBacklog::Clock::time_point came{};  // when it was sent on its way
  // Of the first who asked for it, and of those who asked again with its key.
  std::vector<CommitCallback> done;

  // As it is kept.
  CommitRecord Record() const;
};

struct SceneStore::Entry {
  // `log`  null: the scene is in memory only
  static std::shared_ptr<Entry> Make(std::shared_ptr<const Scene> scene,
                                     std::shared_ptr<SceneLog> log);

  std::string incarnation;
  std::shared_ptr<SceneLog> log;  // null: in memory only

  std::mutex mutex;  // guards all below; one commit at a time, so that watchers hear in order
  std::vector<std::weak_ptr<SceneWatcher>> watchers;
  std::map<std::string, CommitRecord> answers;  // by idempotency key, without their deltas
  std::deque<std::string> answer_order;         // oldest first
  bool is_deleted = false;
  // The scene with all pending commits.
  std::shared_ptr<const Scene> newest;
  std::deque<std::shared_ptr<Pending>> pending;  // oldest first
  uint64_t pending_bytes = 0;                    // of their requests
  bool is_writing = false;                       // a task is going to take the pending, or does

  // Those that go on disk next.
  Batch NextBatch();
  // Everything that was acknowledged, `scene` being the newest of it.
  SceneState Whole(const Scene& scene);
  // What those whose commits have been answered need not wait for; `last` is after these.
  void Tidy(const Scene& last);
};

// What a scene has in a group of commits that go to the journal together.
struct SceneStore::JournalPart {
  std::shared_ptr<Entry> entry;
  Batch batch;
  std::vector<JournalEntry> entries;  // of the batch
};

}  // namespace penumbra
