#include "proto/archive/archive_scenes.h"

#include <iterator>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

template <typename T>
void Append(std::vector<T>&& from, std::vector<T>& to) {
  to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
}

absl::Status OverQuota(const char* reason, const char* field, uint64_t limit) {
  return FieldError(absl::StatusCode::kResourceExhausted, reason, field,
                    absl::StrCat("found more, need at most ", limit));
}

}  // namespace

ArchiveScenes::ArchiveScenes(const std::string& scene_id, const BlobSource& blobs,
                             const SceneLimits& limits)
    : blobs_(blobs), limits_(limits), scene_(Scene::Empty(scene_id)) {}

absl::Status ArchiveScenes::Begin(const ArchivedHead& head) {
  head_ = head;
  return head.base_revision == 0 ? Check(head.base_content_hash) : absl::OkStatus();
}

absl::Status ArchiveScenes::AddBase(const ArchivedBase& base) {
  auto piece = FromProto(base.delta, blobs_);
  if (!piece.ok()) return WithFieldPrefix(piece.status(), "base.");
  Append(std::move(piece->upsert_instances), base_.upsert_instances);
  Append(std::move(piece->upsert_lights), base_.upsert_lights);
  Append(std::move(piece->upsert_receivers), base_.upsert_receivers);
  // Before there are more of them than a scene may have: pieces could go on for ever.
  if (base_.upsert_instances.size() > limits_.max_instances) {
    return OverQuota("QUOTA_INSTANCES", "base.upsert_instances", limits_.max_instances);
  }
  if (base_.upsert_lights.size() > limits_.max_lights) {
    return OverQuota("QUOTA_LIGHTS", "base.upsert_lights", limits_.max_lights);
  }
  if (base_.upsert_receivers.size() > limits_.max_receivers) {
    return OverQuota("QUOTA_RECEIVERS", "base.upsert_receivers", limits_.max_receivers);
  }
  if (!base.is_last) return absl::OkStatus();
  auto scene = scene_->Apply(base_, limits_);
  base_ = {};
  if (!scene.ok()) return WithFieldPrefix(scene.status(), "base.");
  scene_ = (*scene)->WithRevision(head_.base_revision);
  return Check(head_.base_content_hash);
}

absl::StatusOr<SceneDelta> ArchiveScenes::Apply(const CommitRecord& commit,
                                                const v1::SceneDelta& message) {
  auto delta = FromProto(message, blobs_);
  if (!delta.ok()) return WithFieldPrefix(delta.status(), "delta.");
  auto scene = scene_->Apply(*delta, limits_);
  if (!scene.ok()) return WithFieldPrefix(scene.status(), "delta.");
  scene_ = (*scene)->WithRevision(commit.revision);
  if (auto status = Check(commit.content_hash); !status.ok()) return status;
  return delta;
}

absl::Status ArchiveScenes::Check(const ContentHash& expected) const {
  if (scene_->content_hash() == expected) return absl::OkStatus();
  return FieldError(absl::StatusCode::kInvalidArgument, "HASH_MISMATCH", "content_hash",
                    absl::StrCat("found ", scene_->content_hash().hex(), " at revision ",
                                 scene_->revision(), ", need ", expected.hex()));
}

}  // namespace penumbra
