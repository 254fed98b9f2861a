// Rows of a scene's file as values.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "server/storage/database.h"
#include "server/storage/scene_record.h"

namespace penumbra {

// What has been found is not what was written.
absl::Status Damaged(std::string_view found);

// Errors  kDataLoss DAMAGED
absl::StatusOr<ContentHash> HashIn(const Statement& row, int column);

inline constexpr char kCommitColumns[] =
    "SELECT revision, content_hash, key, fingerprint, author, time_ms, delta FROM commits ";
// Of a row of kCommitColumns. Errors  kDataLoss DAMAGED
absl::StatusOr<CommitRecord> CommitIn(const Statement& row);

// What ties a commit to those before it.
struct ChainLink {
  ContentHash delta_hash;
  ContentHash previous;  // chain before the commit
  ContentHash chain;     // after it
};
ChainLink LinkOf(const ContentHash& previous, const CommitRecord& commit);

struct ChainedCommit {
  CommitRecord commit;
  ChainLink link;
};

// The columns of a table that keeps chained commits, in the order in which the next two know them.
inline constexpr char kChainedColumns[] =
    "revision, content_hash, key, fingerprint, author, time_ms, delta, delta_hash, previous, chain";
// Of a row that begins with kChainedColumns. Errors  kDataLoss DAMAGED: it does not fit its hashes
absl::StatusOr<ChainedCommit> ChainedCommitIn(const Statement& row);
// The parameters 1 to 10 of `insert`, which is run.
absl::Status InsertChained(Statement& insert, const CommitRecord& commit, const ChainLink& link,
                           bool with_delta);

// Of a row that begins with revision, content_hash, body. Errors  kDataLoss DAMAGED
absl::StatusOr<SnapshotRecord> SnapshotIn(const Statement& row);

// Calls `visit` with each row, until it returns an error.
template <typename Visit>
absl::Status ForEachRow(Statement& rows, Visit visit) {
  while (true) {
    const auto row = rows.Step();
    if (!row.ok()) return row.status();
    if (!*row) return absl::OkStatus();
    if (absl::Status status = visit(rows); !status.ok()) return status;
  }
}

}  // namespace penumbra
