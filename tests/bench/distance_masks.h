// Masks of blocked texels that distance transforms are measured on.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "render/technique/shadow_width/distance_mask.h"

namespace penumbra::bench {

struct DistanceMask {
  std::string name;
  uint32_t side;
  bool is_of_shadows;            // as blockers cast them: of some size, on lit ground
  std::vector<uint8_t> blocked;  // side²

  BlockedMask View() const { return {blocked, side, side}; }
};

// What a lamp sees of scattered boxes and of a heap of balls and boxes; disks of up to 12 texels,
// and five of up to a quarter of the side; noise; all blocked but 64 texels, and but one. The same
// ones each time.
std::vector<DistanceMask> DistanceMasks(uint32_t side);

}  // namespace penumbra::bench
