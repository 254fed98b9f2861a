#include "server/scene_store/history_reading.h"

#include <limits>
#include <optional>
#include <utility>

#include "server/scene_store/stored_scene.h"
#include "server/storage/scene_rows.h"

namespace penumbra {
namespace {

// Of deltas; read within some milliseconds.
constexpr uint64_t kPieceBytes = 1u << 20;
constexpr Revision kNewest = std::numeric_limits<int64_t>::max();

using Visit = std::function<absl::Status(std::string_view)>;

// `scene` with the commits up to `revision` applied, or with those before the first that is not
// kept any more.
absl::StatusOr<std::shared_ptr<const Scene>> Advance(std::shared_ptr<const Scene> scene,
                                                     SceneLog& log, Revision revision,
                                                     const BlobSource& blobs,
                                                     const SceneLimits& limits) {
  while (scene->revision() < revision) {
    const auto commits = log.CommitsAfter(scene->revision(), revision, kPieceBytes);
    if (!commits.ok()) return commits.status();
    if (commits->empty() || commits->front().revision != scene->revision() + 1) break;
    auto next = SceneAfter(std::move(scene), *commits, blobs, limits);
    if (!next.ok()) return next.status();
    scene = *std::move(next);
  }
  return scene;
}

absl::Status VisitSnapshots(SceneLog& log, const Visit& visit) {
  for (Revision at = 0;;) {
    const auto snapshot = log.SnapshotAfter(at);
    if (!snapshot.ok()) return snapshot.status();
    if (!*snapshot) return absl::OkStatus();
    if (auto status = visit((*snapshot)->body); !status.ok()) return status;
    at = (*snapshot)->revision;
  }
}

absl::Status VisitDeltas(SceneLog& log, const Visit& visit) {
  for (Revision at = 0;;) {
    const auto commits = log.CommitsAfter(at, kNewest, kPieceBytes);
    if (!commits.ok()) return commits.status();
    if (commits->empty()) return absl::OkStatus();
    for (const CommitRecord& commit : *commits) {
      if (auto status = visit(commit.delta); !status.ok()) return status;
    }
    at = commits->back().revision;
  }
}

absl::Status VisitPinned(SceneLog& log, Revision oldest, const Visit& visit) {
  if (auto status = VisitSnapshots(log, visit); !status.ok()) return status;
  if (auto status = VisitDeltas(log, visit); !status.ok()) return status;
  const auto after = log.Pin();
  if (!after.ok()) return after.status();
  log.Unpin();
  if (after->oldest == oldest) return absl::OkStatus();
  return absl::AbortedError("scene: found its history begun anew, need to read it again");
}

}  // namespace

absl::StatusOr<std::shared_ptr<const Scene>> PastScene(SceneLog& log, Revision revision,
                                                       const BlobSource& blobs,
                                                       const SceneLimits& limits) {
  std::optional<Revision> base;
  for (;;) {
    auto snapshot = log.SnapshotFor(revision);
    if (!snapshot.ok()) return snapshot.status();
    const Revision newer = *snapshot ? (*snapshot)->revision : 0;
    // Commits are forgotten up to a snapshot, never between what is kept.
    if (base && newer <= *base) return Damaged("a commit missing");
    base = newer;
    auto start =
        SceneOf(log.identity().scene_id, {.snapshot = *std::move(snapshot)}, blobs, limits);
    if (!start.ok()) return start.status();
    auto scene = Advance(*std::move(start), log, revision, blobs, limits);
    if (!scene.ok() || (*scene)->revision() == revision) return scene;
  }
}

absl::Status ForEachBody(SceneLog& log, const Visit& visit) {
  const auto span = log.Pin();
  absl::Status status = span.status();
  if (span.ok()) {
    status = VisitPinned(log, span->oldest, visit);
    log.Unpin();
  }
  return absl::IsNotFound(status) ? absl::OkStatus() : status;
}

}  // namespace penumbra
