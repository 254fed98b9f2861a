// Masks that distances are tested on, and their exact distances from trying all lit texels.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "render/technique/shadow_width/distance_mask.h"
#include "tests/support/random_scene.h"

namespace penumbra::testing {

struct OwnedMask {
  uint32_t width, height;
  std::vector<uint8_t> blocked;

  OwnedMask(uint32_t w, uint32_t h, bool is_blocked)
      : width(w), height(h), blocked(size_t{w} * h, is_blocked ? uint8_t{1} : uint8_t{0}) {}

  uint8_t& At(int64_t x, int64_t y) { return blocked[y * width + x]; }
  uint8_t At(int64_t x, int64_t y) const { return blocked[y * width + x]; }
  bool IsBlocked(int64_t x, int64_t y) const {
    return x >= 0 && y >= 0 && x < width && y < height && At(x, y) != 0;
  }
  BlockedMask View() const { return {blocked, width, height}; }
};

inline void FillDisk(OwnedMask& mask, double cx, double cy, double radius, uint8_t value) {
  for (int64_t y = 0; y < mask.height; ++y) {
    for (int64_t x = 0; x < mask.width; ++x) {
      if (std::hypot(x - cx, y - cy) <= radius) mask.At(x, y) = value;
    }
  }
}

// Noise of any density, a few lit texels, disks on either ground, or bars.
inline OwnedMask RandomMask(Dice& dice, uint32_t width, uint32_t height) {
  const uint32_t kind = dice.Below(5);
  OwnedMask mask(width, height, kind == 1 || kind == 2);
  const float most = static_cast<float>(std::max(width, height));
  if (kind == 0) {
    const float density = dice.Between(0, 1);
    for (uint8_t& texel : mask.blocked) texel = dice.Between(0, 1) < density ? 255 : 0;
  } else if (kind == 1) {
    for (uint32_t k = 1 + dice.Below(4); k > 0; --k)
      mask.At(dice.Below(width), dice.Below(height)) = 0;
  } else if (kind < 4) {
    for (int k = 0; k < 5; ++k) {
      FillDisk(mask, dice.Between(0, static_cast<float>(width)),
               dice.Between(0, static_cast<float>(height)), dice.Between(0, most / 3),
               kind == 2 ? 0 : 7);
    }
  } else {
    const int64_t period = 2 + dice.Below(100), slope = dice.Below(3);
    for (int64_t y = 0; y < height; ++y) {
      for (int64_t x = 0; x < width; ++x) mask.At(x, y) = (x + slope * y) % period != 0;
    }
  }
  return mask;
}

// Squared distances. The nearest lit texel has a blocked one beside it, on the way to it.
inline std::vector<int64_t> SquaresByTrying(const OwnedMask& mask) {
  std::vector<std::pair<int64_t, int64_t>> lit;
  for (int64_t y = 0; y < mask.height; ++y) {
    for (int64_t x = 0; x < mask.width; ++x) {
      const bool is_edge = mask.IsBlocked(x - 1, y) || mask.IsBlocked(x + 1, y) ||
                           mask.IsBlocked(x, y - 1) || mask.IsBlocked(x, y + 1);
      if (is_edge && !mask.IsBlocked(x, y)) lit.emplace_back(x, y);
    }
  }
  std::vector<int64_t> squares(mask.blocked.size(), 0);
  for (int64_t y = 0; y < mask.height; ++y) {
    for (int64_t x = 0; x < mask.width; ++x) {
      if (!mask.IsBlocked(x, y)) continue;
      int64_t least = std::numeric_limits<int64_t>::max();
      for (const auto& [lx, ly] : lit) {
        least = std::min(least, (x - lx) * (x - lx) + (y - ly) * (y - ly));
      }
      squares[y * mask.width + x] = least;
    }
  }
  return squares;
}

}  // namespace penumbra::testing
