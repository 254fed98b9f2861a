// How a scene's file grows and forgets.

#include <algorithm>
#include <utility>

#include "server/storage/scene_file.h"

namespace penumbra {

absl::Status SceneFile::WriteHead(const SceneHead& head) {
  if (!update_head_) {
    auto prepared =
        database_.Prepare("UPDATE scene SET head_revision = ?, head_chain = ?, seal = ?");
    if (!prepared.ok()) return prepared.status();
    update_head_ = *std::move(prepared);
  }
  Statement* const update = &*update_head_;
  const ContentHash seal = SealOf(identity_, head);
  update->Bind(1, head.revision);
  update->BindBlob(2, BytesOf(head.chain));
  update->BindBlob(3, BytesOf(seal));
  return update->Run();
}

absl::Status SceneFile::Insert(const CommitRecord& commit, bool with_delta, SceneHead& head) {
  if (!insert_commit_) {
    auto prepared = database_.Prepare("INSERT INTO commits VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
    if (!prepared.ok()) return prepared.status();
    insert_commit_ = *std::move(prepared);
  }
  Statement* const insert = &*insert_commit_;
  const ContentHash delta_hash = HashOfBytes(commit.delta);
  const ContentHash chain = NextChain(head.chain, commit, delta_hash);
  insert->Bind(1, commit.revision);
  insert->BindBlob(2, BytesOf(commit.content_hash));
  insert->BindText(3, commit.key);
  insert->BindBlob(4, BytesOf(commit.fingerprint));
  insert->BindText(5, commit.author);
  insert->Bind(6, commit.time_ms);
  if (with_delta) insert->BindBlob(7, commit.delta);
  insert->BindBlob(8, BytesOf(delta_hash));
  insert->BindBlob(9, BytesOf(head.chain));
  insert->BindBlob(10, BytesOf(chain));
  if (auto status = insert->Run(); !status.ok()) return status;
  head = {.revision = commit.revision, .chain = chain};
  return absl::OkStatus();
}

absl::Status SceneFile::Insert(const SnapshotRecord& snapshot, const ContentHash& chain) {
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

absl::Status SceneFile::Append(std::span<const CommitRecord> commits) {
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
  if (auto status = WriteHead(head); !status.ok()) return status;
  if (auto status = transaction->Commit(); !status.ok()) return status;
  head_ = head;
  commits_since_ += commits.size();
  bytes_since_ += bytes;
  return absl::OkStatus();
}

absl::Status SceneFile::Settle() {
  if (auto status = database_.Checkpoint(); !status.ok()) return status;
  database_.CheckpointOnClose(true);
  return absl::OkStatus();
}

bool SceneFile::is_snapshot_due(const HistoryLimits& limits) const {
  constexpr uint64_t kTimesItsSize = 4;
  return commits_since_ >= limits.commits ||
         bytes_since_ >= std::max(limits.snapshot_after_bytes, kTimesItsSize * snapshot_bytes_);
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

// History begins anew at the newest snapshot that has enough commits after it.
absl::Status SceneFile::Forget(const HistoryLimits& limits) {
  if (head_.revision < limits.commits) return absl::OkStatus();
  auto base = database_.Prepare("SELECT max(revision) FROM snapshots WHERE revision <= ?");
  if (!base.ok()) return base.status();
  base->Bind(1, head_.revision - limits.commits);
  if (const auto row = base->Step(); !row.ok()) return row.status();
  if (base->IsNull(0)) return absl::OkStatus();
  const int64_t oldest = base->Integer(0);
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
