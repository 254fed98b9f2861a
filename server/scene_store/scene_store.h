// The scenes, the order of their commits, and who has to know of them.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "render/engine/engine.h"
#include "server/counters.h"
#include "server/limits.h"

namespace penumbra {

// Told of each commit to a scene, in their order, and of its end. Calls must not block.
class SceneWatcher {
 public:
  virtual ~SceneWatcher() = default;
  virtual void OnScene(std::shared_ptr<const Scene> scene) = 0;
  virtual void OnSceneDeleted(const absl::Status& reason) = 0;
};

// A commit as a client asks for it.
struct CommitRequest {
  const SceneDelta& delta;
  std::string idempotency_key;  // empty: none
  ContentHash fingerprint;      // of the delta, where there is a key
};

struct WatchedScene {
  std::shared_ptr<const Scene> scene;
  // Different for every scene ever made: an id may be given again after a deletion.
  uint64_t incarnation = 0;
};

struct CommitOutcome {
  Revision revision = 0;
  ContentHash content_hash;
  std::shared_ptr<const Scene> scene;  // null where an earlier answer was repeated
};

// Any thread may use it.
class SceneStore {
 public:
  SceneStore(Engine& engine, const ServerLimits& limits, ServerCounters& counters)
      : engine_(engine), limits_(limits), counters_(counters) {}

  // Errors  those of Engine
  absl::StatusOr<SceneInfo> Create(const std::string& scene_id);
  absl::Status Delete(const std::string& scene_id);
  absl::StatusOr<std::vector<SceneInfo>> List() { return engine_.ListScenes(); }

  // The scene as it is; `watcher` hears of everything after that until it is gone.
  // Errors  kNotFound
  absl::StatusOr<WatchedScene> Watch(const std::string& scene_id,
                                     std::weak_ptr<SceneWatcher> watcher);

  // How the first commit with this key was answered; none where there has been none.
  // Errors  kNotFound; kInvalidArgument REQUEST_ID_REUSED, BAD_ID
  absl::StatusOr<std::optional<CommitOutcome>> FirstAnswer(const std::string& scene_id,
                                                           const std::string& idempotency_key,
                                                           const ContentHash& fingerprint);

  // Watchers other than `author` are told of the new scene.
  // Errors  those of Engine::Commit; kInvalidArgument REQUEST_ID_REUSED, BAD_ID
  absl::StatusOr<CommitOutcome> Commit(const std::string& scene_id, const CommitRequest& request,
                                       const SceneWatcher* author);

  // Errors  those of Engine::ReportView
  absl::Status ReportView(const std::string& scene_id, const std::string& viewer,
                          const std::optional<View>& view) {
    return engine_.ReportView(scene_id, viewer, view);
  }

  // What the scene is now. Errors  kNotFound
  absl::StatusOr<std::shared_ptr<const Scene>> Snapshot(const std::string& scene_id) {
    return engine_.Snapshot(scene_id);
  }

 private:
  struct Answer {
    ContentHash fingerprint;
    Revision revision = 0;
    ContentHash content_hash;
  };
  using Recalled = absl::StatusOr<std::optional<CommitOutcome>>;
  struct Entry {
    uint64_t incarnation = 0;
    std::mutex mutex;  // one commit at a time, so that watchers hear of them in order
    std::vector<std::weak_ptr<SceneWatcher>> watchers;
    std::map<std::string, Answer> answers;  // by idempotency key
    std::deque<std::string> answer_order;   // oldest first
  };

  absl::StatusOr<std::shared_ptr<Entry>> Find(const std::string& scene_id);
  // With the entry's mutex locked, as for the next.
  Recalled Recall(const Entry& entry, const std::string& key, const ContentHash& fingerprint) const;
  void Remember(Entry& entry, const CommitRequest& request, const Scene& scene);

  Engine& engine_;
  const ServerLimits limits_;
  ServerCounters& counters_;
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<Entry>> entries_;
  uint64_t scenes_made_ = 0;
};

}  // namespace penumbra
