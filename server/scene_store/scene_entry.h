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
  // Of the first who asked for it, and of those who asked again with its key.
  std::vector<CommitCallback> done;
};

struct SceneStore::Entry {
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
  bool is_writing = false;                       // a task is going to take the pending, or does
};

}  // namespace penumbra
