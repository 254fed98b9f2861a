// One face of a shadow-width map from what the light sees there.
//
//   auto face = MakeWidthFace(nearest, layers, {.layers = 2}, find_distances);
#pragma once

#include <functional>
#include <vector>

#include "absl/status/statusor.h"
#include "render/artifact/depth_map.h"
#include "render/artifact/shadow_width_map.h"
#include "render/light_view/shadow_layers.h"
#include "render/technique/shadow_width/distance_mask.h"
#include "render/technique/shadow_width/shadow_width_params.h"

namespace penumbra {

// Distances in texels, of each to the nearest that is lit: 0 where lit, ∞ if none is.
using FindDistances = std::function<absl::StatusOr<std::vector<float>>(const BlockedMask&)>;

// The face that tells of all of its view.
//
// A texel has two layers where something casts between its first receiver and the last one. The
// widths of either one's blocker are then measured to what is lit, or, in the box around such
// texels, blocked by the other one's instance alone: a cup's on a table to where the table is
// seen. Outlines that stay joined, as those of one instance, are the same in both layers. Texels
// with one blocker have its distance to what is lit.
//
// Errors  those of `find_distances`
absl::StatusOr<ShadowWidthFace> MakeWidthFace(const DepthMap& nearest, const ShadowLayers& layers,
                                              const ShadowWidthParams& params,
                                              const FindDistances& find_distances);

}  // namespace penumbra
