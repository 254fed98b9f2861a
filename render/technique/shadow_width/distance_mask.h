// Which texels of a light's view are blocked: what shadow widths are measured in.
//
//   const BlockedMask mask{blocked, 512, 512};
//   if (absl::Status status = CheckMask(mask); !status.ok()) return status;
#pragma once

#include <cstdint>
#include <span>

#include "absl/status/status.h"

namespace penumbra {

// Sums of two squares of distances in texels fit 32 bits with room to spare.
inline constexpr uint32_t kMaxMaskSide = 16384;

struct BlockedMask {
  std::span<const uint8_t> blocked;  // H·W, row by row: 0 lit, anything else blocked
  uint32_t width = 0;
  uint32_t height = 0;
};

// Errors  kInvalidArgument: a side is not in [1, kMaxMaskSide], or `blocked` has another size
absl::Status CheckMask(const BlockedMask& mask);

}  // namespace penumbra
