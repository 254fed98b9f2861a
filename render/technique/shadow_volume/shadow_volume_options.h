// How a shadow's boundary is made, and what there may be of it.
#pragma once

#include <cstddef>
#include <cstdint>

#include "absl/status/status.h"
#include "render/technique/shadow_volume/edge_map.h"
#include "render/technique/shadow_volume/shadow_volume_params.h"
#include "render/technique/shadow_volume/template_mesh.h"

namespace penumbra {

struct ShadowVolumeOptions {
  uint32_t resolution = 512;  // samples along the longer side of a view; along each of six
  EdgeOptions edges;
  bool has_instance_edges = false;  // an edge too where the light sees another instance
  // Lines instead of samples' sides; `reconstruction` does not matter then.
  bool vectorizes = false;
  Reconstruction reconstruction = Reconstruction::kTemplate;
  // ShadowVolumeMesh::bias_px. With 0.1 there were twice as many speckles on slopes; with 1 a sixth
  // fewer pixels were wrong where towers stand on the ground, but an eye as close behind a thin
  // surface as that is not behind its boundary.
  float bias_px = 0.25f;
};

// Errors  kInvalidArgument RANGE, which names the field as "resolution", "bias", "low_threshold",
//         "high_threshold"
absl::Status CheckShadowVolumeOptions(const ShadowVolumeOptions& options);

}  // namespace penumbra
