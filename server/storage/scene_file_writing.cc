// How a scene's file grows and forgets.

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "render/scene/field_error.h"
#include "server/storage/scene_file.h"
#include "server/storage/scene_rows.h"

namespace penumbra {
namespace {

// Columns are signed: past that a scene would be kept as one of a negative revision.
absl::Status CheckFits(Revision revision) {
  constexpr Revision kMost = std::numeric_limits<int64_t>::max();
  if (revision <= kMost) return absl::OkStatus();
  return FieldError(
      absl::StatusCode::kInvalidArgument, "RANGE", "revision",
      "found " + std::to_string(revision) + ", need at most " + std::to_string(kMost));
}

}  // namespace

absl::Status SceneFile::WriteHead(const SceneHead& head, const std::string& journal) {
  if (!update_head_) {
    auto prepared = database_.Prepare(
        "UPDATE scene SET head_revision = ?, head_chain = ?, seal = ?, journal = ?");
    if (!prepared.ok()) return prepared.status();
    update_head_ = *std::move(prepared);
  }
  Statement* const update = &*update_head_;
  const ContentHash seal = SealOf(identity_, head, journal);
  update->Bind(1, head.revision);
  update->BindBlob(2, BytesOf(head.chain));
  update->BindBlob(3, BytesOf(seal));
  update->BindBlob(4, journal);
  return update->Run();
}

absl::Status SceneFile::Insert(const CommitRecord& commit, bool with_delta, SceneHead& head) {
  if (auto status = CheckFits(commit.revision); !status.ok()) return status;
  if (!insert_commit_) {
    auto prepared = database_.Prepare("INSERT INTO commits VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
    if (!prepared.ok()) return prepared.status();
    insert_commit_ = *std::move(prepared);
  }
  const ChainLink link = LinkOf(head.chain, commit);
  if (auto status = InsertChained(*insert_commit_, commit, link, with_delta); !status.ok()) {
    return status;
  }
  head = {.revision = commit.revision, .chain = link.chain};
  return absl::OkStatus();
}

absl::Status SceneFile::Insert(const SnapshotRecord& snapshot, const ContentHash& chain) {
  if (auto status = CheckFits(snapshot.revision); !status.ok()) return status;
  auto insert = database_.Prepare("INSERT OR REPLACE INTO snapshots VALUES (?, ?, ?, ?, ?)");
  if (!insert.ok()) return insert.status();
  const ContentHash hash = HashOf(snapshot);
  insert->Bind(1, snapshot.revision);
  insert->BindBlob(2, BytesOf(snapshot.content_hash));
  insert->BindBlob(3, BytesOf(chain));
  insert->BindBlob(4, snapshot.body);
  insert->BindBlob(5, BytesOf(hash));
  return insert->Run();
}

absl::Status SceneFile::Append(std::span<const CommitRecord> commits, const std::string& journal) {
  auto transaction = Transaction::Begin(database_);
  if (!transaction.ok()) return transaction.status();
  SceneHead head = head_;
  uint64_t bytes = 0;
  for (const CommitRecord& commit : commits) {
    if (commit.revision != head.revision + 1) {
      return absl::InternalError("commits are not in the order of their revisions");
    }
    if (auto status = Insert(commit, /*with_delta=*/true, head); !status.ok()) return status;
    bytes += commit.delta.size();
  }
  if (auto status = WriteHead(head, journal); !status.ok()) return status;
  if (auto status = transaction->Commit(); !status.ok()) return status;
  head_ = head;
  journal_ = journal;
  commits_since_ += commits.size();
  bytes_since_ += bytes;
  return absl::OkStatus();
}

absl::Status SceneFile::Settle() {
  if (auto status = database_.Checkpoint(); !status.ok()) return status;
  if (auto status = Upgrade(); !status.ok()) return status;
  database_.CheckpointOnClose(true);
  return absl::OkStatus();
}

absl::Status SceneFile::CheckpointIfDue() {
  if (database_.log_pages() < checkpoint_pages_) return absl::OkStatus();
  return database_.CheckpointInPlace();
}

bool SceneFile::is_snapshot_due(const HistoryLimits& limits, uint64_t commits,
                                uint64_t bytes) const {
  constexpr uint64_t kTimesItsSize = 4;
  const uint64_t many = std::max(limits.snapshot_after_bytes, kTimesItsSize * snapshot_bytes_);
  return commits_since_ + commits >= limits.commits ||
         bytes_since_ + bytes >= std::min(many, limits.bytes / 2);
}

absl::Status SceneFile::AppendSnapshot(const SnapshotRecord& snapshot,
                                       const HistoryLimits& limits) {
  auto transaction = Transaction::Begin(database_);
  if (!transaction.ok()) return transaction.status();
  if (auto status = Insert(snapshot, head_.chain); !status.ok()) return status;
  if (auto status = Forget(limits); !status.ok()) return status;
  if (auto status = transaction->Commit(); !status.ok()) return status;
  commits_since_ = 0;
  bytes_since_ = 0;
  snapshot_bytes_ = snapshot.body.size();
  return absl::OkStatus();
}

// Where history is to begin: at the newest snapshot that has enough commits after it, or at an even
// newer one where those take too much. None: where it does.
absl::StatusOr<std::optional<Revision>> SceneFile::NewBase(const HistoryLimits& limits) {
  std::optional<Revision> base;
  auto rows = database_.Prepare(
      "SELECT revision, length(body), (SELECT coalesce(sum(length(delta)), 0) FROM commits WHERE "
      "commits.revision > snapshots.revision) FROM snapshots UNION ALL SELECT 0, 0, (SELECT "
      "coalesce(sum(length(delta)), 0) FROM commits) ORDER BY 1 DESC");
  if (!rows.ok()) return rows.status();
  uint64_t snapshot_bytes = 0;  // of those that are looked at, but the newest, which stays
  for (;;) {
    const auto row = rows->Step();
    if (!row.ok()) return row.status();
    const auto revision = static_cast<Revision>(rows->Integer(0));
    if (base) snapshot_bytes += static_cast<uint64_t>(rows->Integer(1));
    const uint64_t bytes = snapshot_bytes + static_cast<uint64_t>(rows->Integer(2));
    if (base && bytes > limits.bytes) return base;
    if (revision == 0) return std::nullopt;
    base = revision;
    if (revision + limits.commits <= head_.revision) return base;
  }
}

absl::Status SceneFile::Forget(const HistoryLimits& limits) {
  const auto base = NewBase(limits);
  if (!base.ok()) return base.status();
  if (!*base) return absl::OkStatus();
  const Revision oldest = **base;
  auto snapshots = database_.Prepare("DELETE FROM snapshots WHERE revision < ?");
  if (!snapshots.ok()) return snapshots.status();
  snapshots->Bind(1, oldest);
  if (auto status = snapshots->Run(); !status.ok()) return status;
  auto deltas = database_.Prepare(
      "UPDATE commits SET delta = NULL WHERE revision <= ? AND delta IS NOT NULL");
  if (!deltas.ok()) return deltas.status();
  deltas->Bind(1, oldest);
  if (auto status = deltas->Run(); !status.ok()) return status;
  auto commits = database_.Prepare(
      "DELETE FROM commits WHERE revision <= ?1 AND (key = '' OR revision < (SELECT min(revision) "
      "FROM (SELECT revision FROM commits WHERE key <> '' ORDER BY revision DESC LIMIT ?2)))");
  if (!commits.ok()) return commits.status();
  commits->Bind(1, oldest);
  commits->Bind(2, limits.answers);
  return commits->Run();
}

}  // namespace penumbra
