#include "server/scene_store/scene_import.h"

#include <span>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/field_error.h"
#include "server/scene_store/scene_archives.h"
#include "server/scene_store/stored_scene.h"
#include "server/session/bounded_parse.h"

namespace penumbra {
namespace {

// One transaction's.
constexpr uint64_t kSavedBytes = 1u << 20;
constexpr uint64_t kRowBytes = 256;  // of a commit, besides its delta
// A server's own history is cut once it takes half as much again as it may, or after an export.
constexpr uint64_t kTimesHistory = 2;

absl::Status Invalid(const char* reason, const std::string& field, const std::string& text) {
  return FieldError(absl::StatusCode::kInvalidArgument, reason, field, text);
}

// What a session's hello and commit are held to.
absl::Status CheckTexts(const CommitRecord& commit, const ServerLimits& limits,
                        const std::string& field) {
  if (commit.key.size() > limits.max_idempotency_key_bytes) {
    return Invalid("BAD_ID", field + ".idempotency_key",
                   absl::StrCat("found ", commit.key.size(), " bytes, need at most ",
                                limits.max_idempotency_key_bytes));
  }
  if (!commit.key.empty()) {
    if (auto status = CheckId(commit.key, field + ".idempotency_key"); !status.ok()) return status;
  }
  if (commit.author.size() <= limits.max_client_name_bytes) return absl::OkStatus();
  return Invalid("LENGTH", field + ".author_name",
                 absl::StrCat("found ", commit.author.size(), " bytes, need at most ",
                              limits.max_client_name_bytes));
}

// An error of the bytes, which are a delta here and a request elsewhere.
absl::Status OfDelta(const absl::Status& status, const std::string& field) {
  constexpr std::string_view kRequest = "request: ";
  std::string text(status.message());
  if (text.starts_with(kRequest)) text.erase(0, kRequest.size());
  return FieldError(status.code(), ErrorReason(status), field + ".delta", text);
}

absl::StatusOr<v1::SceneDelta> DeltaOf(const CommitRecord& commit, const ServerLimits& limits,
                                       uint64_t max_bytes, const std::string& field) {
  ServerLimits bounds = limits;
  bounds.max_message_bytes = static_cast<uint32_t>(max_bytes);
  v1::SceneDelta delta;
  const auto* bytes = reinterpret_cast<const uint8_t*>(commit.delta.data());
  if (auto status = ParseBounded(std::span(bytes, commit.delta.size()), bounds, delta);
      !status.ok()) {
    return OfDelta(status, field);
  }
  // What these do depends on more than the scene before.
  if (delta.has_base_revision() || delta.has_receive_on_planar_surfaces()) {
    return Invalid("UNEXPECTED_FIELD", field + ".delta",
                   "found base_revision or receive_on_planar_surfaces, need objects alone");
  }
  return delta;
}

}  // namespace

absl::Status HeldBlobs::Hold(const ContentHash& hash) {
  if (auto mesh = blobs_.FindMesh(hash)) {
    meshes_[hash] = std::move(mesh);
  } else if (auto mask = blobs_.FindMask(hash)) {
    masks_[hash] = std::move(mask);
  } else {
    return FieldError(absl::StatusCode::kFailedPrecondition, "MISSING_BLOB", "hash",
                      "found " + hash.hex() + ", need a blob that has been uploaded");
  }
  return absl::OkStatus();
}

std::shared_ptr<const Mesh> HeldBlobs::FindMesh(const ContentHash& hash) const {
  const auto found = meshes_.find(hash);
  return found == meshes_.end() ? nullptr : found->second;
}

std::shared_ptr<const AlphaMask> HeldBlobs::FindMask(const ContentHash& hash) const {
  const auto found = masks_.find(hash);
  return found == masks_.end() ? nullptr : found->second;
}

SceneImport::SceneImport(SceneArchives& archives, const std::string& scene_id,
                         const BlobSource& blobs, const ServerLimits& limits)
    : archives_(archives),
      scene_id_(scene_id),
      limits_(limits),
      blobs_(blobs),
      order_({.has_blob_bytes = false,
              .max_blob_bytes = limits.max_blob_bytes,
              .max_delta_bytes = limits.max_transport_message_bytes}),
      scenes_(scene_id, blobs_, limits.scene),
      base_(scenes_.scene()) {}

SceneImport::~SceneImport() {
  file_.reset();
  archives_.Release(scene_id_);
}

absl::Status SceneImport::Take(const v1::ArchiveRecord& record) {
  auto step = order_.Take(record);
  if (!step.ok()) return step.status();
  const auto in_place = [this](const absl::Status& status) {
    return WithFieldPrefix(status, absl::StrCat("records[", order_.record_count() - 1, "]."));
  };
  if (const auto* head = std::get_if<ArchivedHead>(&*step)) return in_place(scenes_.Begin(*head));
  if (const auto* blob = std::get_if<ArchivedBlob>(&*step))
    return in_place(blobs_.Hold(blob->hash));
  if (const auto* base = std::get_if<ArchivedBase>(&*step)) return in_place(TakeBase(*base));
  if (auto* commit = std::get_if<CommitRecord>(&*step)) return TakeCommit(std::move(*commit));
  return absl::OkStatus();
}

absl::Status SceneImport::TakeBase(const ArchivedBase& base) {
  if (auto status = scenes_.AddBase(base); !status.ok()) return status;
  if (base.is_last) base_ = scenes_.scene();
  return absl::OkStatus();
}

absl::Status SceneImport::TakeCommit(CommitRecord commit) {
  const std::string field = absl::StrCat("records[", order_.record_count() - 1, "]");
  if (auto status = CheckTexts(commit, limits_, field); !status.ok()) return status;
  const auto delta = DeltaOf(commit, limits_, limits_.max_transport_message_bytes, field);
  if (!delta.ok()) return delta.status();
  if (auto status = scenes_.Apply(commit, *delta).status(); !status.ok()) {
    return WithFieldPrefix(status, field + ".");
  }
  if (!commit.key.empty()) {
    answers_.push_back(commit);
    answers_.back().delta.clear();
    if (answers_.size() > limits_.max_idempotency_keys) answers_.pop_front();
  }
  if (!archives_.keeps_on_disk()) return absl::OkStatus();
  if (auto status = Count(commit.delta.size() + kRowBytes, field); !status.ok()) return status;
  unsaved_bytes_ += commit.delta.size() + kRowBytes;
  unsaved_.push_back(std::move(commit));
  return unsaved_bytes_ < kSavedBytes ? absl::OkStatus() : Save();
}

absl::Status SceneImport::Count(uint64_t bytes, const std::string& field) {
  history_bytes_ += bytes;
  const uint64_t most = kTimesHistory * limits_.max_history_bytes;
  if (history_bytes_ <= most) return absl::OkStatus();
  return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_HISTORY_BYTES", field,
                    absl::StrCat("found ", history_bytes_, " bytes of history, need at most ", most,
                                 ", or an archive without history"));
}

absl::Status SceneImport::Save() {
  if (!archives_.keeps_on_disk()) return absl::OkStatus();
  if (!file_) {
    SceneState start;
    if (base_->revision() > 0) start.snapshot = SnapshotOf(*base_);
    auto begun = archives_.BeginFile(scene_id_, start);
    if (!begun.ok()) return begun.status();
    file_ = *std::move(begun);
  }
  if (unsaved_.empty()) return absl::OkStatus();
  const absl::Status status = file_->Append(unsaved_);
  unsaved_.clear();
  unsaved_bytes_ = 0;
  return status;
}

absl::StatusOr<SceneInfo> SceneImport::Finish(const std::function<absl::Status()>& is_wanted) {
  if (!order_.has_ended()) {
    return Invalid("LENGTH", "records", "found the end of the call, need the archive's rest");
  }
  if (auto status = Save(); !status.ok()) return status;
  if (auto status = is_wanted(); !status.ok()) return status;
  RestoredScene restored{.scene_id = scene_id_, .status = {}, .scene = scenes_.scene()};
  restored.answers.assign(answers_.begin(), answers_.end());
  if (auto status = archives_.Adopt(std::move(restored), file_.get()); !status.ok()) return status;
  return InfoOf(*scenes_.scene());
}

}  // namespace penumbra
