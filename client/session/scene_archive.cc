#include "client/session/scene_archive.h"

#include <map>
#include <span>
#include <utility>
#include <variant>

#include "proto/archive/archive_file_reader.h"
#include "proto/archive/archive_order.h"
#include "proto/archive/archive_scenes.h"
#include "render/scene/blob.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

absl::Status Invalid(const char* reason, const char* field, const std::string& text) {
  return FieldError(absl::StatusCode::kInvalidArgument, reason, field, text);
}

// The blobs that have been read.
class ReadBlobs final : public BlobSource {
 public:
  absl::Status Add(const ArchivedBlob& blob) {
    auto content = DecodeBlob(std::as_bytes(std::span(blob.bytes)));
    if (!content.ok()) return content.status();
    const ContentHash found = std::visit([](const auto& read) { return read->id(); }, *content);
    if (found != blob.hash) {
      return Invalid("HASH_MISMATCH", "blob.hash",
                     "found the content of " + found.hex() + ", need " + blob.hash.hex());
    }
    if (auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&*content)) {
      meshes_[blob.hash] = std::move(*mesh);
    } else {
      masks_[blob.hash] = std::move(std::get<std::shared_ptr<const AlphaMask>>(*content));
    }
    return absl::OkStatus();
  }
  std::shared_ptr<const Mesh> FindMesh(const ContentHash& hash) const override {
    const auto found = meshes_.find(hash);
    return found == meshes_.end() ? nullptr : found->second;
  }
  std::shared_ptr<const AlphaMask> FindMask(const ContentHash& hash) const override {
    const auto found = masks_.find(hash);
    return found == masks_.end() ? nullptr : found->second;
  }

 private:
  std::map<ContentHash, std::shared_ptr<const Mesh>> meshes_;
  std::map<ContentHash, std::shared_ptr<const AlphaMask>> masks_;
};

// Tells a visitor what records make.
class Reading {
 public:
  explicit Reading(const ArchiveVisitor& visitor) : visitor_(visitor) {}

  absl::Status Take(const v1::ArchiveRecord& record) {
    auto step = order_.Take(record);
    if (!step.ok()) return step.status();
    return std::visit([this](auto& made) { return On(made); }, *step);
  }
  bool has_ended() const { return order_.has_ended(); }
  ArchiveInfo TakeInfo() {
    info_.scene = scenes_->scene();
    return std::move(info_);
  }
  // What a visitor said, which is no matter of the archive.
  const absl::Status& told() const { return told_; }

 private:
  absl::Status On(std::monostate&) { return absl::OkStatus(); }
  absl::Status On(ArchivedEnd&) { return absl::OkStatus(); }
  absl::Status On(ArchivedHead& head) {
    info_.scene_id = head.scene_id;
    info_.base_revision = head.base_revision;
    info_.revision = head.revision;
    info_.server_name = head.server_name;
    info_.time_ms = head.time_ms;
    scenes_ = std::make_unique<ArchiveScenes>(head.scene_id, blobs_, SceneLimits{});
    if (auto status = scenes_->Begin(head); !status.ok()) return status;
    // Of an empty one nothing more is going to be read.
    return head.base_revision == 0 ? TellBase() : absl::OkStatus();
  }
  absl::Status On(ArchivedBlob& blob) {
    info_.blobs.push_back({.hash = blob.hash, .size_bytes = blob.size_bytes});
    return blobs_.Add(blob);
  }
  absl::Status On(ArchivedBase& base) {
    if (auto status = scenes_->AddBase(base); !status.ok()) return status;
    return base.is_last ? TellBase() : absl::OkStatus();
  }
  absl::Status On(CommitRecord& commit) {
    v1::SceneDelta message;
    if (!message.ParseFromString(commit.delta)) {
      return Invalid("MALFORMED", "commit.delta", "found bytes that are no delta, need one");
    }
    const auto delta = scenes_->Apply(commit, message);
    if (!delta.ok()) return delta.status();
    if (!visitor_.on_change) return absl::OkStatus();
    told_ = visitor_.on_change({.delta = *delta,
                                .scene = scenes_->scene(),
                                .author = commit.author,
                                .time_ms = commit.time_ms});
    return told_;
  }
  absl::Status TellBase() {
    if (visitor_.on_base) told_ = visitor_.on_base(scenes_->scene());
    return told_;
  }

  const ArchiveVisitor& visitor_;
  ArchiveOrder order_{{}};
  ReadBlobs blobs_;
  std::unique_ptr<ArchiveScenes> scenes_;
  ArchiveInfo info_;
  absl::Status told_;
};

}  // namespace

absl::StatusOr<ArchiveInfo> ReadArchive(const std::filesystem::path& path,
                                        const ArchiveVisitor& visitor) {
  const auto reader = ArchiveFileReader::Open(path);
  if (!reader.ok()) return reader.status();
  Reading reading(visitor);
  while (true) {
    if (visitor.stop.stop_requested()) return absl::CancelledError(path.string() + ": stopped");
    const auto record = (*reader)->Next();
    if (!record.ok()) return record.status();
    if (!*record) break;
    if (auto status = reading.Take(**record); !status.ok()) {
      return reading.told().ok() ? (*reader)->AtRecord(status) : status;
    }
  }
  ArchiveInfo info = reading.TakeInfo();
  info.file_bytes = (*reader)->size_bytes();
  return info;
}

}  // namespace penumbra
