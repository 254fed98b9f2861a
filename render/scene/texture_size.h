// How many texels a receiver gets along an edge where none are asked for.
//
//   receiver.width = AutoSide(glm::length(patch.edge_u), kTexelsPerMetre, kMaxAutoSide);
#pragma once

#include <algorithm>
#include <cstdint>

namespace penumbra {

// A wall of 4 m gets the 256 texels that are the most: 16 mm each, about the width of a sharp
// penumbra of a ceiling lamp at the foot of a chair.
inline constexpr float kTexelsPerMetre = 64.0f;
inline constexpr uint32_t kMaxAutoSide = 256;
// Fewer cost no less: the work of a receiver that small is all in its occluders.
inline constexpr uint32_t kMinAutoSide = 16;
// Finer than a wavelength of light is a mistake.
inline constexpr float kMaxTexelsPerMetre = 1e6f;

// The smallest power of two that gives `texels_per_metre` texels a metre or more, between
// kMinAutoSide and `max_side` (which need be neither a power of two nor above kMinAutoSide).
//
// Source  Herf and Heckbert 1996: a power of two for each side by the polygon's size in the world,
//         clamped at 256
constexpr uint32_t AutoSide(double length_m, double texels_per_metre, uint32_t max_side) {
  uint32_t side = kMinAutoSide;
  while (side < max_side && side < length_m * texels_per_metre) side *= 2;
  return std::min(side, max_side);
}

}  // namespace penumbra
