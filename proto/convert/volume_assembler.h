// Shadow volume meshes put together from the parts that they name.
//
//   VolumeAssembler volumes(limits);
//   absl::Status status = volumes.Begin(header.shadow_volume_mesh(), starts_from_nothing);
//   status = volumes.Add(part);        // each, a head before the parts it is the first to name
//   status = volumes.Finish(mesh);     // keeps what the next one may name
#pragma once

#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "penumbra/v1/artifact.pb.h"
#include "render/artifact/shadow_volume_mesh.h"
#include "render/scene/scene_limits.h"

namespace penumbra {

class VolumeAssembler {
 public:
  explicit VolumeAssembler(const SceneLimits& limits) : limits_(limits) {}

  // Errors  kInvalidArgument LENGTH, RANGE: names that are none, or too many
  absl::Status Begin(const v1::ShadowVolumeMesh& proto, bool starts_from_nothing);
  // Errors  those; RANGE: a part that nothing names
  absl::Status Add(const v1::VolumePart& part);
  // Volumes that a mesh before had are the same objects.
  //
  // Errors  kDataLoss INCOMPLETE: a part is missing; kInvalidArgument RANGE, NON_FINITE, CODEC,
  //         LENGTH: a part that cannot be, or more samples or vertices than `limits` allow
  absl::Status Finish(ShadowVolumeMesh& mesh);

 private:
  using Part = std::shared_ptr<const v1::VolumePart>;
  using Names = google::protobuf::RepeatedPtrField<std::string>;

  absl::Status Want(const std::string& name, const std::string& field);
  absl::Status WantPartsOf(const v1::VolumePart& part);
  absl::StatusOr<std::vector<std::string>> WithoutLists(const Names& names) const;
  absl::Status CheckWhole(const ShadowVolumeMesh& mesh) const;
  absl::StatusOr<std::shared_ptr<const ShadowVolume>> VolumeOf(const std::string& name);
  const v1::VolumePart* Find(const std::string& name) const;

  SceneLimits limits_;
  Names heads_;                                  // of the mesh in the making, in its order
  std::unordered_map<std::string, Part> next_;   // all that it names; null: not there yet
  std::unordered_map<std::string, Part> parts_;  // of the newest complete one
  std::unordered_map<std::string, std::shared_ptr<const ShadowVolume>> volumes_;  // by their heads
};

}  // namespace penumbra
