// Depth images of a scene from a few points of a light.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "render/light_view/depth_source.h"
#include "render/scene/scene.h"
#include "render/technique/coherent_raytrace/depth_pyramid.h"
#include "tbb/task_arena.h"

namespace penumbra {

struct ReferenceImageSettings {
  uint32_t pixels = 1536;              // along the longer side of an image, 1 … 8192
  size_t max_bytes = size_t{2} << 30;  // of all images
  GapBias gap;
  // Where they are seen from: positions, or of distant lights unit directions to the light. Empty:
  // the light's vertices (LightVertices).
  std::vector<Vec3> places;
};

// Errors  kInvalidArgument, RANGE or NON_FINITE: "resolution", "gap_bias", "places[1]";
//         kResourceExhausted, QUOTA_IMAGE_BYTES: "resolution"; those of `source`
absl::StatusOr<std::vector<DepthPyramid>> DrawReferenceImages(
    const AreaLight& light, const Scene& scene, const ReferenceImageSettings& settings,
    DepthSource& source, tbb::task_arena& arena, const std::stop_token& stop = {});

}  // namespace penumbra
