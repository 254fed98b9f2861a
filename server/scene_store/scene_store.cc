#include "server/scene_store/scene_store.h"

#include <algorithm>
#include <utility>

#include "proto/convert/scene_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

absl::Status CheckKey(const std::string& key, uint32_t max_bytes) {
  if (key.size() > max_bytes) {
    return FieldError(absl::StatusCode::kInvalidArgument, "BAD_ID", "idempotency_key",
                      "found " + std::to_string(key.size()) + " bytes, need at most " +
                          std::to_string(max_bytes));
  }
  return CheckId(key, "idempotency_key");
}

}  // namespace

absl::StatusOr<SceneInfo> SceneStore::Create(const std::string& scene_id) {
  std::lock_guard lock(mutex_);
  if (auto status = engine_.CreateScene(scene_id); !status.ok()) return status;
  auto entry = std::make_shared<Entry>();
  entry->incarnation = ++scenes_made_;
  entries_[scene_id] = std::move(entry);
  const auto scene = engine_.Snapshot(scene_id);
  if (!scene.ok()) return scene.status();
  return InfoOf(**scene);
}

absl::Status SceneStore::Delete(const std::string& scene_id) {
  std::shared_ptr<Entry> entry;
  {
    std::lock_guard lock(mutex_);
    if (auto status = engine_.DeleteScene(scene_id); !status.ok()) return status;
    const auto found = entries_.find(scene_id);
    if (found == entries_.end()) return absl::OkStatus();
    entry = std::move(found->second);
    entries_.erase(found);
  }
  const auto reason = FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "scene_id",
                                 "found '" + scene_id + "', which was deleted, need a scene");
  std::vector<std::shared_ptr<SceneWatcher>> watchers;
  {
    std::lock_guard lock(entry->mutex);
    for (const auto& weak : entry->watchers) {
      if (auto watcher = weak.lock()) watchers.push_back(std::move(watcher));
    }
  }
  for (const auto& watcher : watchers) watcher->OnSceneDeleted(reason);
  return absl::OkStatus();
}

absl::StatusOr<WatchedScene> SceneStore::Watch(const std::string& scene_id,
                                               std::weak_ptr<SceneWatcher> watcher) {
  const auto entry = Find(scene_id);
  if (!entry.ok()) return entry.status();
  std::lock_guard lock((*entry)->mutex);
  auto scene = engine_.Snapshot(scene_id);
  if (!scene.ok()) return scene.status();
  std::erase_if((*entry)->watchers, [](const auto& weak) { return weak.expired(); });
  (*entry)->watchers.push_back(std::move(watcher));
  return WatchedScene{*std::move(scene), (*entry)->incarnation};
}

SceneStore::Recalled SceneStore::FirstAnswer(const std::string& scene_id,
                                             const std::string& idempotency_key,
                                             const ContentHash& fingerprint) {
  const auto found = Find(scene_id);
  if (!found.ok()) return found.status();
  std::lock_guard lock((*found)->mutex);
  return Recall(**found, idempotency_key, fingerprint);
}

absl::StatusOr<CommitOutcome> SceneStore::Commit(const std::string& scene_id,
                                                 const CommitRequest& request,
                                                 const SceneWatcher* author) {
  const bool has_key = !request.idempotency_key.empty();
  const auto found = Find(scene_id);
  if (!found.ok()) return found.status();
  Entry& entry = **found;
  std::lock_guard lock(entry.mutex);
  if (has_key) {
    const auto first = Recall(entry, request.idempotency_key, request.fingerprint);
    if (!first.ok()) return first.status();
    if (*first) return **first;
  }
  const auto revision = engine_.Commit(scene_id, request.delta);
  if (!revision.ok()) return revision.status();
  ++counters_.commits;
  auto scene = engine_.Snapshot(scene_id);
  if (!scene.ok()) return scene.status();
  if (has_key) Remember(entry, request, **scene);
  std::erase_if(entry.watchers, [&](const std::weak_ptr<SceneWatcher>& weak) {
    const auto watcher = weak.lock();
    if (watcher && watcher.get() != author) watcher->OnScene(*scene);
    return watcher == nullptr;
  });
  return CommitOutcome{(*scene)->revision(), (*scene)->content_hash(), *scene};
}

absl::StatusOr<std::shared_ptr<SceneStore::Entry>> SceneStore::Find(const std::string& scene_id) {
  std::lock_guard lock(mutex_);
  const auto entry = entries_.find(scene_id);
  if (entry != entries_.end()) return entry->second;
  return FieldError(
      absl::StatusCode::kNotFound, "UNKNOWN_ID", "scene_id",
      "found '" + scene_id.substr(0, limits_.scene.max_id_bytes) + "', need the id of a scene");
}

SceneStore::Recalled SceneStore::Recall(const Entry& entry, const std::string& key,
                                        const ContentHash& fingerprint) const {
  if (auto status = CheckKey(key, limits_.max_idempotency_key_bytes); !status.ok()) return status;
  const auto first = entry.answers.find(key);
  if (first == entry.answers.end()) return std::nullopt;
  if (first->second.fingerprint == fingerprint) {
    return CommitOutcome{first->second.revision, first->second.content_hash, nullptr};
  }
  return FieldError(absl::StatusCode::kInvalidArgument, "REQUEST_ID_REUSED", "idempotency_key",
                    "found '" + key + "', which stands for another delta, need a new key");
}

void SceneStore::Remember(Entry& entry, const CommitRequest& request, const Scene& scene) {
  entry.answers[request.idempotency_key] = {request.fingerprint, scene.revision(),
                                            scene.content_hash()};
  entry.answer_order.push_back(request.idempotency_key);
  if (entry.answer_order.size() <= limits_.max_idempotency_keys) return;
  entry.answers.erase(entry.answer_order.front());
  entry.answer_order.pop_front();
}

}  // namespace penumbra
