// A shadow volume from its parts.
//
//   VolumeBuilder builder(limits);
//   absl::Status status = builder.Begin(head);
//   status = builder.Add(part);             // each that the head names, in its order
//   auto volume = builder.Finish();
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "penumbra/v1/artifact.pb.h"
#include "proto/convert/plane_codec.h"
#include "render/artifact/shadow_volume_mesh.h"
#include "render/scene/scene_limits.h"

namespace penumbra {

class VolumeBuilder {
 public:
  explicit VolumeBuilder(const SceneLimits& limits) : limits_(limits) {}

  // Errors  kInvalidArgument RANGE, NON_FINITE, LENGTH: what cannot be, or more samples than
  //         `limits` allow, found before anything is allocated
  absl::Status Begin(const v1::VolumeHead& head);
  // Errors  the same, and CODEC
  absl::Status Add(const v1::VolumePart& part);
  // Errors  kDataLoss INCOMPLETE: depths are missing; kInvalidArgument RANGE: weights are
  absl::StatusOr<ShadowVolume> Finish();

 private:
  absl::Status AddDepths(const v1::VolumeDepths& proto);
  absl::Status AddTriangles(const v1::VolumeTriangles& proto);
  absl::StatusOr<std::span<const float>> Floats(const v1::FloatPlane& proto, size_t count,
                                                const char* field);
  absl::Status AddFace(const v1::VolumeFace& proto, const std::string& field);
  absl::Status AddVertices(const v1::VolumeTriangles& proto);
  absl::Status AddWeights(const v1::VolumeTriangles& proto);

  const SceneLimits& limits_;
  ShadowVolume volume_;
  std::vector<std::vector<bool>> has_tile_;  // of each face
  uint64_t samples_ = 0;
  PlaneUnpacker unpacker_;
  std::vector<float> floats_;
};

}  // namespace penumbra
