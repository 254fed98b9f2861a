// Shadow widths as the paper has graphics hardware find them: each pass looks at a few neighbours,
// and twice as far as the one before.
//
//   auto widths = DistanceBySteps(context, mask, StepNeighbours::kSix, stop);
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "render/gl/context.h"
#include "render/math/vec.h"
#include "render/technique/shadow_width/distance_mask.h"

namespace penumbra {

enum class StepNeighbours : uint8_t {
  kThree,  // at 90°, 210° and 330°, 0° being towards the next column, 90° towards the next row
  kSix,    // those across from them too
};

// A neighbour that a pass looks at.
struct DistanceStep {
  glm::ivec2 offset;  // in texels
  float length;       // of `offset`
};

// The neighbours `size` texels away, each rounded to a texel, halves towards the middle: of size 1
// they are the texels of the next row, left and right, of six that of the row before too.
std::vector<DistanceStep> StepsOf(StepNeighbours neighbours, int size);

// The shortest of the ways from each texel to lit ones that have at most one step of each size 1,
// 2, 4, …, less than the mask's longer side, the longest first; 0 where lit, infinity where no such
// way is. A step out of the mask ends at its edge. As a way is as long as its steps together, it is
// never shorter than the exact distance, but for rounding; most are longer: steps lie in few
// directions.
//
// Shapes  H×W → H·W, row by row
// Units   texels, which are square
// Errors  kInvalidArgument: as CheckMask, or a side is more than a texture's may be; kCancelled:
//         stop requested, asked every 20 ms or so; kResourceExhausted: out of memory;
//         kUnavailable: the context is lost
// Cost    O(W·H·log max(W, H))
// Source  Kirsch and Döllner 2003, §4, "Generating Shadow Widths"; departs: floats instead of 8
//         bits, a step counts as far as it leads, and widths have no limit. The paper does not say
//         where its three and six neighbours lie.
absl::StatusOr<std::vector<float>> DistanceBySteps(gl::Context& context, const BlockedMask& mask,
                                                   StepNeighbours neighbours,
                                                   const std::stop_token& stop);

}  // namespace penumbra
