#include "server/scene_store/scene_archives.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"
#include "server/scene_store/scene_entry.h"
#include "server/scene_store/stored_scene.h"

namespace penumbra {

absl::StatusOr<std::unique_ptr<SceneExport>> SceneArchives::Export(const std::string& scene_id,
                                                                   bool with_history) {
  const auto entry = store_.Find(scene_id);
  if (!entry.ok()) return entry.status();
  const size_t max_bytes = store_.limits_.max_message_bytes;
  if (with_history && (*entry)->log) {
    return SceneExport::OfHistory((*entry)->log, store_.blobs_, max_bytes);
  }
  const auto scene = store_.engine_.Snapshot(scene_id);
  if (!scene.ok()) return scene.status();
  return SceneExport::OfScene(*scene, (*entry)->incarnation, store_.blobs_, max_bytes);
}

absl::StatusOr<std::unique_ptr<SceneImport>> SceneArchives::Import(const std::string& scene_id,
                                                                   const SceneOwner& owner,
                                                                   const BlobSource& blobs) {
  if (auto status = CheckId(scene_id, "scene_id"); !status.ok()) return status;
  if (auto status = Reserve(scene_id); !status.ok()) return status;
  if (auto status = store_.owners_.Take(owner, scene_id); !status.ok()) {
    Release(scene_id);
    return status;
  }
  return std::make_unique<SceneImport>(*this, scene_id, blobs, store_.limits_);
}

absl::StatusOr<std::shared_ptr<void>> SceneArchives::TakeTurn() {
  std::lock_guard lock(mutex_);
  const uint32_t limit = store_.limits_.archives.max_transfers;
  if (turns_taken_ >= limit) {
    return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_ARCHIVES", "",
                      absl::StrCat("found ", turns_taken_,
                                   " exports and imports under way, need fewer than ", limit));
  }
  ++turns_taken_;
  return std::shared_ptr<void>(nullptr, [this](void*) {
    std::lock_guard over(mutex_);
    --turns_taken_;
  });
}

absl::Status SceneArchives::Reserve(const std::string& scene_id) {
  std::lock_guard lock(store_.mutex_);
  if (store_.entries_.contains(scene_id) || store_.refused_.contains(scene_id) ||
      store_.changing_.contains(scene_id)) {
    return FieldError(absl::StatusCode::kAlreadyExists, "DUPLICATE_ID", "scene_id",
                      absl::StrCat("found '", scene_id, "', which exists; need an id not in use"));
  }
  // Before everything is sent; the engine is asked again at the end.
  if (store_.entries_.size() >= store_.limits_.max_scenes) {
    return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_SCENES", "scene_id",
                      absl::StrCat("found ", store_.entries_.size(), " scenes, need fewer than ",
                                   store_.limits_.max_scenes, " before another"));
  }
  store_.changing_.insert(scene_id);
  return absl::OkStatus();
}

void SceneArchives::Release(const std::string& scene_id) {
  bool is_there = false;
  {
    std::lock_guard lock(store_.mutex_);
    is_there = store_.entries_.contains(scene_id);
  }
  // The id is not given to others before.
  if (!is_there) store_.owners_.Drop(scene_id);
  std::lock_guard lock(store_.mutex_);
  store_.changing_.erase(scene_id);
}

absl::StatusOr<std::unique_ptr<ImportedFile>> SceneArchives::BeginFile(const std::string& scene_id,
                                                                       const SceneState& start) {
  return store_.storage_->BeginImport(scene_id, start);
}

absl::Status SceneArchives::Adopt(RestoredScene restored, ImportedFile* file) {
  if (file) {
    auto log = store_.storage_->Adopt(*file);
    if (!log.ok()) return log.status();
    restored.log = *std::move(log);
    // A history that was exported whole may be due for a snapshot; later, if not now.
    restored.log->Tidy([&] { return SnapshotOf(*restored.scene); }).IgnoreError();
  }
  if (auto status = store_.engine_.RestoreScene(restored.scene); !status.ok()) {
    if (restored.log) store_.storage_->Remove(*restored.log).IgnoreError();
    return status;
  }
  auto entry = SceneStore::Entry::Make(restored.scene, restored.log);
  for (const CommitRecord& answer : restored.answers) store_.Remember(*entry, answer);
  std::lock_guard lock(store_.mutex_);
  store_.entries_[restored.scene_id] = std::move(entry);
  return absl::OkStatus();
}

}  // namespace penumbra
