#include "server/storage/scene_rows.h"

#include <algorithm>
#include <utility>

#include "render/scene/field_error.h"

namespace penumbra {

absl::Status Damaged(std::string_view found) {
  return FieldError(absl::StatusCode::kDataLoss, "DAMAGED", "scene",
                    "found " + std::string(found) + ", need it as it was written");
}

absl::StatusOr<ContentHash> HashIn(const Statement& row, int column) {
  const std::string_view bytes = row.Blob(column);
  ContentHash hash;
  if (bytes.size() != hash.bytes.size()) return Damaged("a hash of another length");
  std::copy(bytes.begin(), bytes.end(), hash.bytes.begin());
  return hash;
}

absl::StatusOr<CommitRecord> CommitIn(const Statement& row) {
  const auto content_hash = HashIn(row, 1);
  if (!content_hash.ok()) return content_hash.status();
  const auto fingerprint = HashIn(row, 3);
  if (!fingerprint.ok()) return fingerprint.status();
  return CommitRecord{.revision = static_cast<Revision>(row.Integer(0)),
                      .content_hash = *content_hash,
                      .key = std::string(row.Text(2)),
                      .fingerprint = *fingerprint,
                      .author = std::string(row.Text(4)),
                      .time_ms = row.Integer(5),
                      .delta = std::string(row.Blob(6))};
}

ChainLink LinkOf(const ContentHash& previous, const CommitRecord& commit) {
  const ContentHash delta_hash = HashOfBytes(commit.delta);
  return {delta_hash, previous, NextChain(previous, commit, delta_hash)};
}

absl::StatusOr<ChainedCommit> ChainedCommitIn(const Statement& row) {
  auto commit = CommitIn(row);
  if (!commit.ok()) return commit.status();
  const auto delta_hash = HashIn(row, 7), previous = HashIn(row, 8), chain = HashIn(row, 9);
  if (!delta_hash.ok() || !previous.ok() || !chain.ok()) return Damaged("hashes of no length");
  if (*chain != NextChain(*previous, *commit, *delta_hash)) {
    return Damaged("a commit that does not fit its hash");
  }
  if (!row.IsNull(6) && HashOfBytes(commit->delta) != *delta_hash) {
    return Damaged("a delta that does not fit its hash");
  }
  return ChainedCommit{*std::move(commit), {*delta_hash, *previous, *chain}};
}

absl::Status InsertChained(Statement& insert, const CommitRecord& commit, const ChainLink& link,
                           bool with_delta) {
  insert.Bind(1, commit.revision);
  insert.BindBlob(2, BytesOf(commit.content_hash));
  insert.BindText(3, commit.key);
  insert.BindBlob(4, BytesOf(commit.fingerprint));
  insert.BindText(5, commit.author);
  insert.Bind(6, commit.time_ms);
  if (with_delta) insert.BindBlob(7, commit.delta);
  insert.BindBlob(8, BytesOf(link.delta_hash));
  insert.BindBlob(9, BytesOf(link.previous));
  insert.BindBlob(10, BytesOf(link.chain));
  return insert.Run();
}

absl::StatusOr<SnapshotRecord> SnapshotIn(const Statement& row) {
  const auto content_hash = HashIn(row, 1);
  if (!content_hash.ok()) return content_hash.status();
  return SnapshotRecord{.revision = static_cast<Revision>(row.Integer(0)),
                        .content_hash = *content_hash,
                        .body = std::string(row.Blob(2))};
}

}  // namespace penumbra
