#include "server/scene_store/scene_log.h"

#include <utility>

#include "render/scene/field_error.h"

namespace penumbra {

SceneLog::SceneLog(DataDirectory& directory, SceneLogOptions options,
                   std::unique_ptr<SceneFile> file)
    : directory_(directory),
      options_(options),
      identity_(file->identity()),
      file_(std::move(file)) {}

absl::Status SceneLog::Append(std::span<const CommitRecord> commits,
                              const std::function<SceneState()>& whole) {
  std::lock_guard lock(mutex_);
  if (is_removed_) return CheckFile();
  if (!file_) {
    if (auto status = BeginAnew(whole()); !status.ok()) return status;
  }
  const absl::Status status = file_->Append(commits);
  // Room on the disk is asked for before anything counts as written: a full one leaves no doubt.
  if (!status.ok() && !absl::IsResourceExhausted(status)) Abandon();
  return status;
}

void SceneLog::Abandon() {
  file_->Abandon();
  file_.reset();
}

absl::Status SceneLog::BeginAnew(const SceneState& whole) {
  const auto number = directory_.NextNumber(identity_.scene_id);
  if (!number.ok()) return number.status();
  auto file = SceneFile::Create(directory_.ScenePath(identity_.scene_id, *number), identity_,
                                options_.database, whole);
  if (!file.ok()) return file.status();
  if (auto status = (*file)->Settle(); !status.ok()) return status;
  file_ = *std::move(file);
  // The old ones are passed over from here on, whether or not they can be removed.
  directory_.RemoveScene(identity_.scene_id, *number).IgnoreError();
  return absl::OkStatus();
}

absl::Status SceneLog::Compact(const std::function<SnapshotRecord()>& snapshot) {
  std::lock_guard lock(mutex_);
  if (!file_ || !file_->is_snapshot_due(options_.history)) return absl::OkStatus();
  const absl::Status status = file_->AppendSnapshot(snapshot(), options_.history);
  if (!status.ok() && !absl::IsResourceExhausted(status)) Abandon();
  return status;
}

absl::StatusOr<SceneState> SceneLog::StateAt(Revision revision) {
  std::lock_guard lock(mutex_);
  if (auto status = CheckFile(); !status.ok()) return status;
  return file_->StateAt(revision);
}

absl::Status SceneLog::ForEachBody(const std::function<absl::Status(std::string_view)>& visit) {
  std::lock_guard lock(mutex_);
  if (is_removed_) return absl::OkStatus();
  if (auto status = CheckFile(); !status.ok()) return status;
  return file_->ForEachBody(visit);
}

absl::Status SceneLog::Remove() {
  std::lock_guard lock(mutex_);
  is_removed_ = true;
  file_.reset();
  return directory_.RemoveScene(identity_.scene_id, 0);
}

absl::Status SceneLog::CheckFile() const {
  if (file_) return absl::OkStatus();
  return FieldError(absl::StatusCode::kUnavailable, "STORAGE_FAILED", "scene",
                    is_removed_ ? "found it removed, need a scene"
                                : "found a disk that failed, need it to work again");
}

}  // namespace penumbra
