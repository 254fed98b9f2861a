// The records of an archive, one after another: whether they come in the right order and number,
// and whether each commit follows from the one before.
//
//   ArchiveOrder order({});
//   while (record = …) {
//     auto step = order.Take(record);
//     if (!step.ok()) return step.status();
//     if (const auto* commit = std::get_if<CommitRecord>(&*step)) …
//   }
//   if (!order.has_ended()) …   // something is missing
//
// What the deltas make of a scene is for archive_scenes.h.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "absl/container/flat_hash_set.h"
#include "absl/status/statusor.h"
#include "penumbra/v1/archive.pb.h"
#include "render/scene/commit_record.h"

namespace penumbra {

inline constexpr uint32_t kArchiveFormat = 1;
// 285,000 years of 1,000 commits a second; a file of a scene counts as far, and as much again.
inline constexpr Revision kMaxArchivedRevision = Revision{1} << 53;

// ArchiveHead, checked.
struct ArchivedHead {
  std::string scene_id;
  std::string incarnation;
  Revision base_revision = 0;
  ContentHash base_content_hash;
  ContentHash base_chain;
  Revision revision = 0;
  ContentHash content_hash;
  ContentHash chain;
  uint64_t blob_count = 0;
  std::string server_name;
  int64_t time_ms = 0;
};

struct ArchivedBlob {
  ContentHash hash;
  uint64_t size_bytes = 0;
  std::string bytes;  // all of them, or none where they are left out; not held against the hash
};

struct ArchivedBase {
  v1::SceneDelta delta;
  bool is_last = false;
};

struct ArchivedEnd {};

// What a record completes; nothing where more of it is to come.
using ArchiveStep = std::variant<std::monostate, ArchivedHead, ArchivedBlob, ArchivedBase,
                                 CommitRecord, ArchivedEnd>;

struct ArchiveOrderOptions {
  bool has_blob_bytes = true;  // otherwise blobs are named and do not follow
  uint64_t max_blob_bytes = uint64_t{1} << 30;
  // A session's commit takes a message at most; what it makes of planar surfaces about as much.
  uint64_t max_delta_bytes = uint64_t{4} << 20;
};

class ArchiveOrder {
 public:
  explicit ArchiveOrder(const ArchiveOrderOptions& options) : options_(options) {}

  // Errors  all name the record as "records[7]". kInvalidArgument ARCHIVE_ORDER, LENGTH,
  //         MISSING_FIELD; HASH_MISMATCH: a commit that does not follow from the one before;
  //         kFailedPrecondition VERSION: a newer format; kResourceExhausted QUOTA_BLOB_BYTES,
  //         QUOTA_DELTA_BYTES
  absl::StatusOr<ArchiveStep> Take(const v1::ArchiveRecord& record);
  bool has_ended() const { return stage_ == Stage::kEnded; }
  // Of the archive: the head has been taken.
  const ArchivedHead& head() const { return head_; }
  uint64_t record_count() const { return record_count_; }

 private:
  enum class Stage { kHead, kBlobs, kBase, kCommits, kEnded };

  absl::StatusOr<ArchiveStep> Begin(const v1::ArchiveRecord& record);
  absl::StatusOr<ArchiveStep> TakeHead(const v1::ArchiveHead& head);
  absl::StatusOr<ArchiveStep> TakeBlob(const v1::ArchiveBlob& blob);
  absl::StatusOr<ArchiveStep> TakeBase(const v1::ArchiveBase& base);
  absl::StatusOr<ArchiveStep> TakeCommit(const v1::ArchiveCommit& commit);
  absl::StatusOr<ArchiveStep> TakeEnd();
  absl::StatusOr<ArchiveStep> TakeBytes(const std::string& data);
  absl::StatusOr<ArchiveStep> CompleteCommit();
  absl::Status LeaveBlobs();
  absl::StatusOr<ContentHash> HashIn(const std::string& bytes, const char* field) const;
  absl::Status Wrong(const char* reason, const std::string& text) const;

  const ArchiveOrderOptions options_;
  Stage stage_ = Stage::kHead;
  uint64_t record_count_ = 0;
  ArchivedHead head_;
  absl::flat_hash_set<ContentHash> blobs_;
  // What has begun and is not complete; its bytes so far are in it.
  std::optional<ArchivedBlob> blob_;
  std::optional<CommitRecord> commit_;
  ContentHash commit_chain_;
  uint64_t size_ = 0;
  // Of the last commit, or the base.
  Revision revision_ = 0;
  ContentHash content_hash_;
  ContentHash chain_;
};

}  // namespace penumbra
