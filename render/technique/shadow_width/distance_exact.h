// The exact Euclidean distance transform: how deep in shadow each texel is.
//
//   auto widths = DistanceToLit({blocked, width, height}, arena, stop);
//   if (!widths.ok()) return widths.status();
//   (*widths)[y * width + x]   // 0 where lit
#pragma once

#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "render/technique/shadow_width/distance_mask.h"
#include "tbb/task_arena.h"

namespace penumbra {

// Distance from each texel's centre to the nearest centre of a lit texel; 0 where lit, infinity
// everywhere if no texel is lit. What lies outside of the mask is neither lit nor blocked.
//
//   d(x, y)² = min_j (x − j)² + c(j, y)²,   c(j, y) = min_i |y − i| with (j, i) lit
//
// Squares are exact; one becomes a float and then its root, each rounded once, the former only from
// 2²⁴. The same bits for any number of threads and any instruction set.
//
// Shapes  H×W → H·W, row by row; in the memory of `reused`, where that is large enough: the kernel
//         takes longer to find 16 MB than these distances do
// Units   texels, which are square
// Errors  kInvalidArgument: as CheckMask; kCancelled: stop requested, asked once for 32 rows
// Cost    O(W·H) for masks of wide shadows, with a logarithm of W at worst
// Source  Kirsch and Döllner 2003, §3: the definition of shadow width. Columns, then rows as lower
//         envelopes of parabolas after Felzenszwalb and Huttenlocher 2012; departs: see
//         distance_row-inl.h
absl::StatusOr<std::vector<float>> DistanceToLit(const BlockedMask& mask, tbb::task_arena& arena,
                                                 const std::stop_token& stop,
                                                 std::vector<float> reused = {});

}  // namespace penumbra
