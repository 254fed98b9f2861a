// A scene that is being made of an archive's records: it is there once Finish has returned it, and
// nothing of it before or otherwise.
//
//   for (record : …) imported->Take(record);
//   auto info = imported->Finish([] { return absl::OkStatus(); });
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "proto/archive/archive_order.h"
#include "proto/archive/archive_scenes.h"
#include "server/limits.h"
#include "server/scene_store/imported_file.h"

namespace penumbra {

class SceneArchives;

// Holds blobs, so that none goes before the scene that names it is there.
class HeldBlobs final : public BlobSource {
 public:
  // `blobs` outlives this.
  explicit HeldBlobs(const BlobSource& blobs) : blobs_(blobs) {}
  // Errors  kFailedPrecondition MISSING_BLOB
  absl::Status Hold(const ContentHash& hash);

  std::shared_ptr<const Mesh> FindMesh(const ContentHash& hash) const override;
  std::shared_ptr<const AlphaMask> FindMask(const ContentHash& hash) const override;

 private:
  const BlobSource& blobs_;
  std::map<ContentHash, std::shared_ptr<const Mesh>> meshes_;
  std::map<ContentHash, std::shared_ptr<const AlphaMask>> masks_;
};

// One thread at a time.
class SceneImport {
 public:
  // Has the id to itself; see SceneArchives::Import. `blobs` are those that the client may name.
  SceneImport(SceneArchives& archives, const std::string& scene_id, const BlobSource& blobs,
              const ServerLimits& limits);
  ~SceneImport();

  // Waits for the disk. Errors  those of ArchiveOrder and ArchiveScenes; kFailedPrecondition
  //                             MISSING_BLOB; kInvalidArgument BAD_ID, LENGTH, MALFORMED,
  //                             UNEXPECTED_FIELD; kResourceExhausted QUOTA_HISTORY_BYTES; those
  //                             of SceneFile
  absl::Status Take(const v1::ArchiveRecord& record);
  // Asks `is_wanted` once all is on disk, before the scene is let in.
  // Errors  kInvalidArgument LENGTH: there is more to come; that of `is_wanted`; those of
  //         SceneStorage::Adopt; kResourceExhausted QUOTA_SCENES
  absl::StatusOr<SceneInfo> Finish(const std::function<absl::Status()>& is_wanted);

 private:
  absl::Status TakeBase(const ArchivedBase& base);
  absl::Status TakeCommit(CommitRecord commit);
  absl::Status Count(uint64_t bytes, const std::string& field);
  absl::Status Save();  // the commits that are not on disk yet

  SceneArchives& archives_;
  const std::string scene_id_;
  const ServerLimits limits_;
  HeldBlobs blobs_;
  ArchiveOrder order_;
  ArchiveScenes scenes_;
  std::unique_ptr<ImportedFile> file_;  // null: not begun, or scenes live in memory
  std::vector<CommitRecord> unsaved_;
  uint64_t unsaved_bytes_ = 0;
  uint64_t history_bytes_ = 0;         // of all commits
  std::shared_ptr<const Scene> base_;  // at which the history begins
  std::deque<CommitRecord> answers_;   // commits with a key, without their deltas
};

}  // namespace penumbra
