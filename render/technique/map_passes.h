// Passes of techniques that make maps from the light's middle alone.
#pragma once

#include <cstdint>
#include <vector>

namespace penumbra {

// The first map of a large one has a quarter of its sides, which takes a sixteenth of its time.
inline constexpr uint32_t kCoarseFrom = 1024, kCoarseness = 4;

// The sides of the maps to make, the last as it was asked for.
inline std::vector<uint32_t> MapPasses(uint32_t resolution, bool has_progress) {
  if (!has_progress || resolution < kCoarseFrom) return {resolution};
  return {resolution / kCoarseness, resolution};
}

}  // namespace penumbra
