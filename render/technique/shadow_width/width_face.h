// One face of a shadow-width map from what the light sees there.
//
//   auto face = MakeWidthFace(nearest, layers, {.layers = 2}, find_distances);
#pragma once

#include <cstdint>
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

// The texels that are not lit for receivers that lie above others: those of `layers`, less those
// where such a receiver is seen next to what blocks its light. At a texel whose first and last
// receiver differ, the first one's nearness goes on beyond the outline as it changes from the
// neighbour on the other side; where a neighbour shows a surface there, or one further away, that
// neighbour is lit.
std::vector<uint8_t> BlockedForFirstReceivers(const DepthMap& nearest, const ShadowLayers& layers);

// The face that tells of all of its view. Its second layer is left out where no receiver lies
// above another.
//
// Errors  those of `find_distances`
absl::StatusOr<ShadowWidthFace> MakeWidthFace(const DepthMap& nearest, const ShadowLayers& layers,
                                              const ShadowWidthParams& params,
                                              const FindDistances& find_distances);

}  // namespace penumbra
