// The scenes of an archive: its base, and what each commit makes of the one before, held against
// the content hashes that the archive says.
//
//   ArchiveScenes scenes("studio", blobs, limits);
//   scenes.Begin(head);
//   scenes.AddBase(base);             // until it is the last piece
//   auto delta = scenes.Apply(commit, message);
//   Use(scenes.scene());
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "proto/archive/archive_order.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/scene.h"

namespace penumbra {

class ArchiveScenes {
 public:
  // The scenes have the id `scene_id`, whatever the archive's is. `blobs` outlives this.
  ArchiveScenes(const std::string& scene_id, const BlobSource& blobs, const SceneLimits& limits);

  // Errors, of all  those of FromProto and of Scene::Apply, under "base." and "delta.";
  //                 kInvalidArgument HASH_MISMATCH: another scene than the archive says
  absl::Status Begin(const ArchivedHead& head);
  absl::Status AddBase(const ArchivedBase& base);
  // `message` is what the commit's delta reads as. Returns it with its meshes in place.
  absl::StatusOr<SceneDelta> Apply(const CommitRecord& commit, const v1::SceneDelta& message);

  const std::shared_ptr<const Scene>& scene() const { return scene_; }

 private:
  absl::Status Check(const ContentHash& expected) const;

  const BlobSource& blobs_;
  const SceneLimits limits_;
  ArchivedHead head_;
  SceneDelta base_;  // the pieces so far
  std::shared_ptr<const Scene> scene_;
};

}  // namespace penumbra
