#include "proto/archive/archive_order.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "proto/convert/geometry_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

constexpr size_t kIncarnationBytes = 16;
constexpr char kOrder[] = "ARCHIVE_ORDER";

const char* NameOf(v1::ArchiveRecord::BeginsCase begins) {
  switch (begins) {
    case v1::ArchiveRecord::kHead:
      return "a head";
    case v1::ArchiveRecord::kBlob:
      return "a blob";
    case v1::ArchiveRecord::kBase:
      return "a base";
    case v1::ArchiveRecord::kCommit:
      return "a commit";
    case v1::ArchiveRecord::kEnd:
      return "the end";
    case v1::ArchiveRecord::BEGINS_NOT_SET:
      break;
  }
  return "bytes of nothing";
}

absl::Status BeyondLast(Revision revision) {
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", "records[0].revision",
                    absl::StrCat("found ", revision, ", need at most ", kMaxArchivedRevision));
}

}  // namespace

absl::Status ArchiveOrder::Wrong(const char* reason, const std::string& text) const {
  return FieldError(absl::StatusCode::kInvalidArgument, reason,
                    absl::StrCat("records[", record_count_ - 1, "]"), text);
}

absl::StatusOr<ContentHash> ArchiveOrder::HashIn(const std::string& bytes,
                                                 const char* field) const {
  return HashFromProto(bytes, absl::StrCat("records[", record_count_ - 1, "].", field));
}

absl::StatusOr<ArchiveStep> ArchiveOrder::Take(const v1::ArchiveRecord& record) {
  ++record_count_;
  if (has_ended()) return Wrong(kOrder, "found something after the end, need nothing");
  if (!blob_ && !commit_) return Begin(record);
  if (record.begins_case() != v1::ArchiveRecord::BEGINS_NOT_SET) {
    return Wrong("LENGTH", absl::StrCat("found ", NameOf(record.begins_case()),
                                        ", need the rest of what the one before began"));
  }
  return TakeBytes(record.data());
}

absl::StatusOr<ArchiveStep> ArchiveOrder::Begin(const v1::ArchiveRecord& record) {
  absl::StatusOr<ArchiveStep> step;
  switch (record.begins_case()) {
    case v1::ArchiveRecord::kHead:
      step = TakeHead(record.head());
      break;
    case v1::ArchiveRecord::kBlob:
      step = TakeBlob(record.blob());
      break;
    case v1::ArchiveRecord::kBase:
      step = TakeBase(record.base());
      break;
    case v1::ArchiveRecord::kCommit:
      step = TakeCommit(record.commit());
      break;
    case v1::ArchiveRecord::kEnd:
      step = TakeEnd();
      break;
    case v1::ArchiveRecord::BEGINS_NOT_SET:
      return Wrong(kOrder, "found bytes of nothing, need what they belong to before");
  }
  if (!step.ok() || blob_ || commit_) return step.ok() ? TakeBytes(record.data()) : step;
  if (!record.data().empty()) return Wrong("LENGTH", "found bytes, need none of this record");
  return step;
}

absl::StatusOr<ArchiveStep> ArchiveOrder::TakeHead(const v1::ArchiveHead& head) {
  if (head.format_version() > kArchiveFormat) {
    return FieldError(absl::StatusCode::kFailedPrecondition, "VERSION", "records[0].format_version",
                      absl::StrCat("found ", head.format_version(), ", need at most ",
                                   kArchiveFormat, ": a newer program wrote it"));
  }
  if (stage_ != Stage::kHead || head.format_version() == 0) {
    return Wrong(kOrder, "found a head, need one first, with a format, and no other");
  }
  if (auto status = CheckId(head.scene_id(), "records[0].scene_id"); !status.ok()) return status;
  if (head.incarnation().size() != kIncarnationBytes || head.revision() < head.base_revision()) {
    return Wrong("RANGE", "found a head of no scene, need 16 bytes and a revision not before base");
  }
  if (head.revision() > kMaxArchivedRevision) return BeyondLast(head.revision());
  const auto base_content = HashIn(head.base_content_hash(), "base_content_hash");
  const auto base_chain = HashIn(head.base_chain(), "base_chain");
  const auto content = HashIn(head.content_hash(), "content_hash");
  const auto chain = HashIn(head.chain(), "chain");
  for (const auto* hash : {&base_content, &base_chain, &content, &chain}) {
    if (!hash->ok()) return hash->status();
  }
  head_ = {.scene_id = head.scene_id(),
           .incarnation = head.incarnation(),
           .base_revision = head.base_revision(),
           .base_content_hash = *base_content,
           .base_chain = *base_chain,
           .revision = head.revision(),
           .content_hash = *content,
           .chain = *chain,
           .blob_count = head.blob_count(),
           .server_name = head.server_name(),
           .time_ms = head.time_ms()};
  stage_ = Stage::kBlobs;
  revision_ = head_.base_revision;
  content_hash_ = head_.base_content_hash;
  chain_ = head_.base_chain;
  return ArchiveStep(head_);
}

absl::StatusOr<ArchiveStep> ArchiveOrder::TakeBlob(const v1::ArchiveBlob& blob) {
  if (stage_ != Stage::kBlobs) return Wrong(kOrder, "found a blob, need blobs after the head");
  const auto hash = HashIn(blob.hash(), "hash");
  if (!hash.ok()) return hash.status();
  if (!blobs_.insert(*hash).second) {
    return Wrong(kOrder, "found blob " + hash->hex() + " again, need each once");
  }
  if (blobs_.size() > head_.blob_count) {
    return Wrong(kOrder, absl::StrCat("found another blob, need ", head_.blob_count));
  }
  if (blob.size_bytes() == 0) return Wrong("LENGTH", "found a blob of 0 bytes, need some");
  if (blob.size_bytes() > options_.max_blob_bytes) {
    return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_BLOB_BYTES",
                      absl::StrCat("records[", record_count_ - 1, "].size_bytes"),
                      absl::StrCat("found ", blob.size_bytes(), ", need at most ",
                                   options_.max_blob_bytes, " bytes in one blob"));
  }
  ArchivedBlob begun{.hash = *hash, .size_bytes = blob.size_bytes()};
  if (!options_.has_blob_bytes) return ArchiveStep(std::move(begun));
  blob_ = std::move(begun);
  size_ = blob.size_bytes();
  return ArchiveStep();
}

absl::Status ArchiveOrder::LeaveBlobs() {
  if (stage_ == Stage::kHead) return Wrong(kOrder, "found no head, need one first");
  if (stage_ != Stage::kBlobs) return absl::OkStatus();
  if (blobs_.size() != head_.blob_count) {
    return Wrong(
        kOrder, absl::StrCat("found ", blobs_.size(), " blobs before it, need ", head_.blob_count));
  }
  stage_ = head_.base_revision > 0 ? Stage::kBase : Stage::kCommits;
  return absl::OkStatus();
}

absl::StatusOr<ArchiveStep> ArchiveOrder::TakeBase(const v1::ArchiveBase& base) {
  if (auto status = LeaveBlobs(); !status.ok()) return status;
  if (stage_ != Stage::kBase) return Wrong(kOrder, "found a base, need none here");
  if (!base.is_continued()) stage_ = Stage::kCommits;
  return ArchiveStep(ArchivedBase{.delta = base.delta(), .is_last = !base.is_continued()});
}

absl::StatusOr<ArchiveStep> ArchiveOrder::TakeCommit(const v1::ArchiveCommit& commit) {
  if (auto status = LeaveBlobs(); !status.ok()) return status;
  if (stage_ != Stage::kCommits) return Wrong(kOrder, "found a commit, need the base first");
  if (commit.revision() != revision_ + 1 || revision_ == head_.revision) {
    return Wrong(kOrder, absl::StrCat("found revision ", commit.revision(), " after ", revision_,
                                      ", need the next, up to ", head_.revision));
  }
  if (commit.delta_size_bytes() > options_.max_delta_bytes) {
    return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_DELTA_BYTES",
                      absl::StrCat("records[", record_count_ - 1, "].delta_size_bytes"),
                      absl::StrCat("found ", commit.delta_size_bytes(), ", need at most ",
                                   options_.max_delta_bytes));
  }
  const auto content = HashIn(commit.content_hash(), "content_hash");
  const auto fingerprint = HashIn(commit.fingerprint(), "fingerprint");
  const auto chain = HashIn(commit.chain(), "chain");
  for (const auto* hash : {&content, &fingerprint, &chain}) {
    if (!hash->ok()) return hash->status();
  }
  commit_ = CommitRecord{.revision = commit.revision(),
                         .content_hash = *content,
                         .key = commit.idempotency_key(),
                         .fingerprint = *fingerprint,
                         .author = commit.author_name(),
                         .time_ms = commit.time_ms()};
  commit_chain_ = *chain;
  size_ = commit.delta_size_bytes();
  return ArchiveStep();
}

absl::StatusOr<ArchiveStep> ArchiveOrder::TakeBytes(const std::string& data) {
  std::string& bytes = blob_ ? blob_->bytes : commit_->delta;
  if (data.size() > size_ - bytes.size()) {
    return Wrong("LENGTH", absl::StrCat("found ", bytes.size() + data.size(), " bytes, need ",
                                        size_, " as announced"));
  }
  bytes += data;
  if (bytes.size() < size_) return ArchiveStep();
  if (commit_) return CompleteCommit();
  ArchivedBlob blob = *std::move(blob_);
  blob_.reset();
  return ArchiveStep(std::move(blob));
}

absl::StatusOr<ArchiveStep> ArchiveOrder::CompleteCommit() {
  CommitRecord commit = *std::move(commit_);
  commit_.reset();
  if (NextChain(chain_, commit, HashOfBytes(commit.delta)) != commit_chain_) {
    return Wrong("HASH_MISMATCH", absl::StrCat("found a commit of revision ", commit.revision,
                                               " that does not fit its hash, need it as it was"));
  }
  revision_ = commit.revision;
  content_hash_ = commit.content_hash;
  chain_ = commit_chain_;
  return ArchiveStep(std::move(commit));
}

absl::StatusOr<ArchiveStep> ArchiveOrder::TakeEnd() {
  if (auto status = LeaveBlobs(); !status.ok()) return status;
  if (stage_ != Stage::kCommits || revision_ != head_.revision) {
    return Wrong(kOrder, absl::StrCat("found the end at revision ", revision_, ", need it at ",
                                      head_.revision));
  }
  if (content_hash_ != head_.content_hash || chain_ != head_.chain) {
    return Wrong("HASH_MISMATCH", "found another history than the head says, need that one");
  }
  stage_ = Stage::kEnded;
  return ArchiveStep(ArchivedEnd{});
}

}  // namespace penumbra
