// Shadow widths from neighbour to neighbour, as the paper has software find them: sweeping over the
// mask, each texel takes what its neighbours have and the way to them. For comparison: the exact
// transform is faster.
//
//   auto widths = DistanceBySweeps({blocked, width, height}, SweepNeighbours::kFour, arena, stop);
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "render/technique/shadow_width/distance_mask.h"
#include "tbb/task_arena.h"

namespace penumbra {

enum class SweepNeighbours : uint8_t {
  kFour,   // left, right, above and below, as the paper has it
  kEight,  // the diagonal ones too, √2 away
};

// The length of the shortest way from each texel to a lit one, from neighbour to neighbour; 0 where
// lit, infinity everywhere if no texel is lit. To a texel that lies (x, y) away, x ≥ y ≥ 0, it is
//
//   x + y  of four neighbours,   x + (√2 − 1) y  of eight.
//
// Never less than the exact distance, but for the rounding to float, and at most √2 times as much
// of four neighbours, 1 / cos(π/8) ≈ 1.08 times as much of eight.
//
// Shapes  H×W → H·W, row by row
// Units   texels, which are square
// Errors  kInvalidArgument: as CheckMask; kCancelled: stop requested, asked once a row
// Source  Kirsch and Döllner 2003, §4, "Generating Shadow Widths"; departs: no limit to widths, and
//         the diagonals
absl::StatusOr<std::vector<float>> DistanceBySweeps(const BlockedMask& mask,
                                                    SweepNeighbours neighbours,
                                                    tbb::task_arena& arena,
                                                    const std::stop_token& stop);

}  // namespace penumbra
