#include "server/storage/scene_rows.h"

#include <algorithm>

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

absl::StatusOr<SnapshotRecord> SnapshotIn(const Statement& row) {
  const auto content_hash = HashIn(row, 1);
  if (!content_hash.ok()) return content_hash.status();
  return SnapshotRecord{.revision = static_cast<Revision>(row.Integer(0)),
                        .content_hash = *content_hash,
                        .body = std::string(row.Blob(2))};
}

}  // namespace penumbra
