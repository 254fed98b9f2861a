// Rays through a block of a view's pixels, and what they meet.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "render/light_view/shadow_layers.h"

namespace penumbra {

// Pixels along a side of a packet of rays.
inline constexpr uint32_t kBlock = 4;
inline constexpr size_t kPacket = size_t{kBlock} * kBlock;

using Depths = std::array<double, kPacket>;

// −1 where a ray is wanted, otherwise 0; aligned as Embree asks.
struct Lanes {
  alignas(64) std::array<int, kPacket> wanted{};

  int& operator[](size_t k) { return wanted[k]; }
  int operator[](size_t k) const { return wanted[k]; }
  bool none() const {
    return std::ranges::all_of(wanted, [](int one) { return one == 0; });
  }
};

struct Met {
  std::array<float, kPacket> depths;
  std::array<uint32_t, kPacket> parts;

  bool HasHit(size_t k) const { return parts[k] != kNoBlocker; }
  uint32_t PartOr(uint32_t part, size_t k) const { return HasHit(k) ? parts[k] : part; }
  float NotBefore(float depth, size_t k) const {
    return HasHit(k) ? std::max(depth, depths[k]) : depth;
  }
};

// Where rays start from what is nearest: just before it, just behind it, and behind all there is.
struct Starts {
  Lanes lanes;
  Depths before{}, behind{}, end{}, same{};  // the last: within which two surfaces are one
};

}  // namespace penumbra
