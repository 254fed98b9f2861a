#include "server/scene_store/scene_export.h"

#include <algorithm>
#include <chrono>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "proto/archive/archive_order.h"
#include "proto/archive/base_pieces.h"
#include "proto/convert/geometry_convert.h"
#include "render/scene/field_error.h"
#include "render/scene/scene_difference.h"
#include "server/server_identity.h"
#include "server/storage/scene_rows.h"

namespace penumbra {
namespace {

// What a record takes besides its bytes: a commit's hashes, key and author.
constexpr size_t kRecordBytes = 1024;
constexpr size_t kFramingBytes = 8;
// Of one blob or delta in one record.
constexpr size_t kChunkBytes = 256u << 10;
constexpr uint64_t kBatchBytes = 1u << 20;

absl::Status BegunAnew() {
  return absl::AbortedError("scene: found its history begun anew, need to export it again");
}

v1::ArchiveHead HeadOf(const SceneIdentity& identity) {
  v1::ArchiveHead head;
  head.set_format_version(kArchiveFormat);
  head.set_scene_id(identity.scene_id);
  head.set_incarnation(identity.incarnation);
  head.set_server_name(kServerName);
  head.set_time_ms(std::chrono::duration_cast<std::chrono::milliseconds>(
                       std::chrono::system_clock::now().time_since_epoch())
                       .count());
  return head;
}

absl::Status CollectFrom(const v1::SceneDelta& delta, std::set<ContentHash>& hashes) {
  for (const v1::Instance& instance : delta.upsert_instances()) {
    for (const std::string* bytes : {&instance.mesh_hash(), &instance.alpha_mask_hash()}) {
      if (bytes->empty()) continue;
      const auto hash = HashFromProto(*bytes, "hash");
      if (!hash.ok()) return Damaged("a blob of no name");
      hashes.insert(*hash);
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<SceneExport>> SceneExport::OfHistory(std::shared_ptr<SceneLog> log,
                                                                    const BlobStore& blobs,
                                                                    size_t max_message_bytes) {
  const auto span = log->Pin();
  if (!span.ok()) return span.status();
  std::unique_ptr<SceneExport> made(new SceneExport(blobs, max_message_bytes));
  made->log_ = std::move(log);
  made->head_ = HeadOf(made->log_->identity());
  made->head_.set_base_revision(span->oldest);
  made->head_.set_base_content_hash(ToProto(span->oldest_content));
  made->head_.set_base_chain(ToProto(span->oldest_chain));
  made->head_.set_revision(span->head.revision);
  made->head_.set_content_hash(ToProto(span->content_hash));
  made->head_.set_chain(ToProto(span->head.chain));
  made->revision_ = span->oldest;
  made->chain_ = span->oldest_chain;
  if (auto status = made->ReadBase(); !status.ok()) return status;
  if (auto status = made->SearchBase(); !status.ok()) return status;
  return made;
}

absl::StatusOr<std::unique_ptr<SceneExport>> SceneExport::OfScene(
    std::shared_ptr<const Scene> scene, const std::string& incarnation, const BlobStore& blobs,
    size_t max_message_bytes) {
  std::unique_ptr<SceneExport> made(new SceneExport(blobs, max_message_bytes));
  const SceneIdentity identity{.scene_id = scene->id(), .incarnation = incarnation, .owner = ""};
  made->head_ = HeadOf(identity);
  made->revision_ = scene->revision();
  made->chain_ = FirstChain(identity);
  made->head_.set_base_revision(scene->revision());
  made->head_.set_revision(scene->revision());
  made->head_.set_base_content_hash(ToProto(scene->content_hash()));
  made->head_.set_content_hash(ToProto(scene->content_hash()));
  made->head_.set_base_chain(ToProto(made->chain_));
  made->head_.set_chain(ToProto(made->chain_));
  if (scene->revision() > 0) {
    auto whole = ToProto(Difference(*Scene::Empty(scene->id()), *scene));
    for (auto& piece : BasePieces(std::move(whole), std::min(kChunkBytes, max_message_bytes / 2))) {
      made->base_left_.push_back(std::move(piece));
    }
  }
  made->scene_ = std::move(scene);
  if (auto status = made->SearchBase(); !status.ok()) return status;
  return made;
}

SceneExport::~SceneExport() {
  if (log_) log_->Unpin();
}

absl::Status SceneExport::ReadBase() {
  if (head_.base_revision() == 0) return absl::OkStatus();
  const auto snapshot = log_->SnapshotFor(head_.base_revision());
  if (absl::IsOutOfRange(snapshot.status())) return BegunAnew();
  if (!snapshot.ok()) return snapshot.status();
  v1::SceneDelta whole;
  if (!*snapshot || (*snapshot)->revision != head_.base_revision() ||
      !whole.ParseFromString((*snapshot)->body)) {
    return Damaged("no snapshot where history begins");
  }
  for (auto& piece : BasePieces(std::move(whole), std::min(kChunkBytes, max_message_bytes_ / 2))) {
    base_left_.push_back(std::move(piece));
  }
  return absl::OkStatus();
}

absl::Status SceneExport::SearchBase() {
  for (const v1::ArchiveBase& piece : base_left_) {
    if (auto status = CollectFrom(piece.delta(), named_); !status.ok()) return status;
  }
  searched_ = head_.base_revision();
  return absl::OkStatus();
}

// All that the base and the commits name comes before them.
absl::Status SceneExport::SearchOn() {
  if (searched_ < head_.revision()) {
    const auto commits = log_->CommitsAfter(searched_, head_.revision(), kBatchBytes);
    if (!commits.ok()) return commits.status();
    if (commits->empty()) return BegunAnew();
    for (const CommitRecord& commit : *commits) {
      v1::SceneDelta delta;
      if (!delta.ParseFromString(commit.delta)) return Damaged("a delta that cannot be read");
      if (auto status = CollectFrom(delta, named_); !status.ok()) return status;
    }
    searched_ = commits->back().revision;
  }
  if (searched_ < head_.revision()) return absl::OkStatus();
  head_.set_blob_count(named_.size());
  blobs_left_.assign(named_.begin(), named_.end());
  named_.clear();
  stage_ = Stage::kHead;
  return absl::OkStatus();
}

absl::StatusOr<bool> SceneExport::Next(v1::ExportSceneResponse& message) {
  if (stage_ == Stage::kSearch) {
    if (auto status = SearchOn(); !status.ok()) return status;
    if (stage_ == Stage::kSearch) return true;
  }
  room_ = max_message_bytes_ - std::min(max_message_bytes_, kRecordBytes);
  for (int counted = 0; room_ > 0;) {
    const auto added = AddRecord(message);
    if (!added.ok()) return added.status();
    if (stage_ == Stage::kOver) return false;
    if (!*added) break;
    for (; counted < message.records_size(); ++counted) {
      room_ -= std::min(room_, message.records(counted).ByteSizeLong() + kFramingBytes);
    }
  }
  return true;
}

// False where the next one does not fit.
absl::StatusOr<bool> SceneExport::AddRecord(v1::ExportSceneResponse& message) {
  absl::Status status;
  if (blob_ || delta_) {
    AddBytes(*message.add_records());
    return true;
  }
  switch (stage_) {
    case Stage::kHead:
      *message.add_records()->mutable_head() = head_;
      stage_ = Stage::kBlobs;
      break;
    case Stage::kBlobs:
      status = AddBlob(message);
      break;
    case Stage::kBase:
      if (!base_left_.empty() && base_left_.front().ByteSizeLong() > room_ &&
          message.records_size() > 0) {
        return false;
      }
      AddBase(message);
      break;
    case Stage::kCommits:
      status = AddCommit(message);
      break;
    case Stage::kEnd:
      message.add_records()->mutable_end();
      stage_ = Stage::kOver;
      break;
    case Stage::kSearch:
    case Stage::kOver:
      break;
  }
  if (!status.ok()) return status;
  return true;
}

absl::Status SceneExport::AddBlob(v1::ExportSceneResponse& message) {
  if (blobs_left_.empty()) {
    stage_ = Stage::kBase;
    return absl::OkStatus();
  }
  auto content = blobs_.Fetch(blobs_left_.front());
  if (!content.ok()) return content.status();
  blob_.emplace(*std::move(content));
  bytes_sent_ = 0;
  v1::ArchiveRecord& record = *message.add_records();
  record.mutable_blob()->set_hash(ToProto(blobs_left_.front()));
  record.mutable_blob()->set_size_bytes(blob_->size());
  blobs_left_.pop_front();
  AddBytes(record);
  return absl::OkStatus();
}

void SceneExport::AddBase(v1::ExportSceneResponse& message) {
  if (base_left_.empty()) {
    stage_ = Stage::kCommits;
    return;
  }
  *message.add_records()->mutable_base() = std::move(base_left_.front());
  base_left_.pop_front();
}

absl::Status SceneExport::AddCommit(v1::ExportSceneResponse& message) {
  if (commits_read_.empty() && revision_ == head_.revision()) {
    stage_ = Stage::kEnd;
    return ToProto(chain_) == head_.chain() ? absl::OkStatus() : Damaged("another history");
  }
  if (commits_read_.empty()) {
    auto commits = log_->CommitsAfter(revision_, head_.revision(), kBatchBytes);
    if (!commits.ok()) return commits.status();
    if (commits->empty()) return BegunAnew();
    revision_ = commits->back().revision;
    commits_read_.assign(std::make_move_iterator(commits->begin()),
                         std::make_move_iterator(commits->end()));
  }
  CommitRecord commit = std::move(commits_read_.front());
  commits_read_.pop_front();
  chain_ = NextChain(chain_, commit, HashOfBytes(commit.delta));
  v1::ArchiveRecord& record = *message.add_records();
  v1::ArchiveCommit& proto = *record.mutable_commit();
  proto.set_revision(commit.revision);
  proto.set_content_hash(ToProto(commit.content_hash));
  proto.set_idempotency_key(commit.key);
  proto.set_fingerprint(ToProto(commit.fingerprint));
  proto.set_author_name(commit.author);
  proto.set_time_ms(commit.time_ms);
  proto.set_chain(ToProto(chain_));
  proto.set_delta_size_bytes(commit.delta.size());
  delta_ = std::move(commit.delta);
  bytes_sent_ = 0;
  AddBytes(record);
  return absl::OkStatus();
}

void SceneExport::AddBytes(v1::ArchiveRecord& record) {
  const size_t all = blob_ ? blob_->size() : delta_->size();
  const size_t size = std::min({kChunkBytes, all - bytes_sent_, room_});
  std::string& data = *record.mutable_data();
  data.resize(size);
  if (blob_) {
    blob_->CopyTo(reinterpret_cast<std::byte*>(data.data()), bytes_sent_, size);
  } else {
    delta_->copy(data.data(), size, bytes_sent_);
  }
  bytes_sent_ += size;
  if (bytes_sent_ < all) return;
  blob_.reset();
  delta_.reset();
}

}  // namespace penumbra
