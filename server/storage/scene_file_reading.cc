// What a scene's file tells.

#include <algorithm>
#include <string>
#include <utility>

#include "render/scene/field_error.h"
#include "server/storage/scene_file.h"
#include "server/storage/scene_rows.h"

namespace penumbra {
namespace {

absl::StatusOr<std::vector<CommitRecord>> CommitsIn(Statement& rows) {
  std::vector<CommitRecord> commits;
  absl::Status status = ForEachRow(rows, [&](const Statement& row) {
    auto commit = CommitIn(row);
    if (commit.ok()) commits.push_back(*std::move(commit));
    return commit.status();
  });
  if (!status.ok()) return status;
  return commits;
}

absl::Status OutOfRange(const char* reason, Revision found, const char* need, Revision limit) {
  return FieldError(
      absl::StatusCode::kOutOfRange, reason, "revision",
      "found " + std::to_string(found) + ", need " + need + " " + std::to_string(limit));
}

}  // namespace

absl::StatusOr<Revision> SceneFile::OldestRevision() {
  auto oldest = database_.Prepare("SELECT coalesce(min(revision), 0) FROM snapshots");
  if (!oldest.ok()) return oldest.status();
  if (const auto row = oldest->Step(); !row.ok()) return row.status();
  const auto snapshot = static_cast<Revision>(oldest->Integer(0));
  if (snapshot == 0) return snapshot;
  // The first commit with its delta: then the empty scene is where history begins.
  auto first =
      database_.Prepare("SELECT count(*) FROM commits WHERE revision = 1 AND delta IS NOT NULL");
  if (!first.ok()) return first.status();
  if (const auto row = first->Step(); !row.ok()) return row.status();
  return first->Integer(0) > 0 ? 0 : snapshot;
}

absl::StatusOr<SceneState> SceneFile::StateAt(Revision revision) {
  if (revision > head_.revision) {
    return OutOfRange("FUTURE_BASE", revision, "at most", head_.revision);
  }
  const auto oldest = OldestRevision();
  if (!oldest.ok()) return oldest.status();
  if (revision < *oldest) return OutOfRange("COMPACTED", revision, "at least", *oldest);
  SceneState state;
  auto snapshot = database_.Prepare(
      "SELECT revision, content_hash, body FROM snapshots WHERE revision <= ? "
      "ORDER BY revision DESC LIMIT 1");
  if (!snapshot.ok()) return snapshot.status();
  snapshot->Bind(1, revision);
  const auto found = snapshot->Step();
  if (!found.ok()) return found.status();
  if (*found) {
    auto newest = SnapshotIn(*snapshot);
    if (!newest.ok()) return newest.status();
    state.snapshot = *std::move(newest);
  }
  auto rows = database_.Prepare(std::string(kCommitColumns) +
                                "WHERE revision > ? AND revision <= ? ORDER BY revision");
  if (!rows.ok()) return rows.status();
  rows->Bind(1, state.snapshot ? state.snapshot->revision : 0);
  rows->Bind(2, revision);
  auto commits = CommitsIn(*rows);
  if (!commits.ok()) return commits.status();
  state.commits = *std::move(commits);
  return state;
}

absl::StatusOr<std::vector<CommitRecord>> SceneFile::History(Revision after) {
  auto rows = database_.Prepare(std::string(kCommitColumns) +
                                "WHERE revision > ? AND delta IS NOT NULL ORDER BY revision");
  if (!rows.ok()) return rows.status();
  rows->Bind(1, after);
  return CommitsIn(*rows);
}

absl::StatusOr<std::vector<CommitRecord>> SceneFile::Answers(const HistoryLimits& limits) {
  auto rows = database_.Prepare(
      "SELECT revision, content_hash, key, fingerprint, author, time_ms, NULL FROM commits "
      "WHERE key <> '' ORDER BY revision DESC LIMIT ?");
  if (!rows.ok()) return rows.status();
  rows->Bind(1, limits.answers);
  auto commits = CommitsIn(*rows);
  if (commits.ok()) std::reverse(commits->begin(), commits->end());
  return commits;
}

absl::Status SceneFile::ForEachBody(const std::function<absl::Status(std::string_view)>& visit) {
  auto rows = database_.Prepare(
      "SELECT body FROM snapshots UNION ALL SELECT delta FROM commits WHERE delta IS NOT NULL");
  if (!rows.ok()) return rows.status();
  return ForEachRow(*rows, [&](const Statement& row) { return visit(row.Blob(0)); });
}

}  // namespace penumbra
