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

absl::StatusOr<std::optional<SnapshotRecord>> FirstSnapshotIn(Statement& rows) {
  const auto found = rows.Step();
  if (!found.ok()) return found.status();
  if (!*found) return std::nullopt;
  auto snapshot = SnapshotIn(rows);
  if (!snapshot.ok()) return snapshot.status();
  return std::optional(*std::move(snapshot));
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

absl::StatusOr<std::optional<SnapshotRecord>> SceneFile::SnapshotFor(Revision revision) {
  if (revision > head_.revision) {
    return OutOfRange("FUTURE_BASE", revision, "at most", head_.revision);
  }
  const auto oldest = OldestRevision();
  if (!oldest.ok()) return oldest.status();
  if (revision < *oldest) return OutOfRange("COMPACTED", revision, "at least", *oldest);
  auto rows = database_.Prepare(
      "SELECT revision, content_hash, body FROM snapshots WHERE revision <= ? "
      "ORDER BY revision DESC LIMIT 1");
  if (!rows.ok()) return rows.status();
  rows->Bind(1, revision);
  return FirstSnapshotIn(*rows);
}

absl::StatusOr<std::optional<SnapshotRecord>> SceneFile::SnapshotAfter(Revision after) {
  auto rows = database_.Prepare(
      "SELECT revision, content_hash, body FROM snapshots WHERE revision > ? "
      "ORDER BY revision LIMIT 1");
  if (!rows.ok()) return rows.status();
  rows->Bind(1, after);
  return FirstSnapshotIn(*rows);
}

absl::StatusOr<SceneState> SceneFile::StateAt(Revision revision) {
  auto snapshot = SnapshotFor(revision);
  if (!snapshot.ok()) return snapshot.status();
  SceneState state{.snapshot = *std::move(snapshot)};
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

absl::StatusOr<HistorySpan> SceneFile::Span() {
  const auto oldest = OldestRevision();
  if (!oldest.ok()) return oldest.status();
  const ContentHash empty = Scene::Empty(identity_.scene_id)->content_hash();
  HistorySpan span{.oldest = *oldest,
                   .oldest_content = empty,
                   .oldest_chain = FirstChain(identity_),
                   .head = head_,
                   .content_hash = empty};
  auto snapshot = database_.Prepare("SELECT content_hash, chain FROM snapshots WHERE revision = ?");
  if (!snapshot.ok()) return snapshot.status();
  snapshot->Bind(1, *oldest);
  const auto found = snapshot->Step();
  if (!found.ok()) return found.status();
  if (*found) {
    const auto content = HashIn(*snapshot, 0), chain = HashIn(*snapshot, 1);
    if (!content.ok() || !chain.ok()) return Damaged("hashes of another length");
    span.oldest_content = *content;
    span.oldest_chain = *chain;
    span.content_hash = *content;
  }
  auto newest = database_.Prepare("SELECT content_hash FROM commits WHERE revision = ?");
  if (!newest.ok()) return newest.status();
  newest->Bind(1, head_.revision);
  const auto is_there = newest->Step();
  if (!is_there.ok()) return is_there.status();
  if (!*is_there) return span;
  const auto content = HashIn(*newest, 0);
  if (!content.ok()) return content.status();
  span.content_hash = *content;
  return span;
}

absl::StatusOr<std::vector<CommitRecord>> SceneFile::CommitsAfter(Revision after, Revision last,
                                                                  uint64_t max_bytes) {
  auto rows = database_.Prepare(
      std::string(kCommitColumns) +
      "WHERE revision > ? AND revision <= ? AND delta IS NOT NULL ORDER BY revision");
  if (!rows.ok()) return rows.status();
  rows->Bind(1, after);
  rows->Bind(2, last);
  std::vector<CommitRecord> commits;
  uint64_t bytes = 0;
  while (bytes < max_bytes) {
    const auto row = rows->Step();
    if (!row.ok()) return row.status();
    if (!*row) break;
    auto commit = CommitIn(*rows);
    if (!commit.ok()) return commit.status();
    constexpr uint64_t kRowBytes = 256;  // of what there is besides the delta
    bytes += commit->delta.size() + kRowBytes;
    commits.push_back(*std::move(commit));
  }
  return commits;
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

}  // namespace penumbra
