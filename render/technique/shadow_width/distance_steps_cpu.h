// The same as DistanceBySteps, bit for bit, where there is no GL to do it.
//
//   auto widths = DistanceByStepsOnCpu(mask, StepNeighbours::kSix, arena, stop);
#pragma once

#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "render/technique/shadow_width/distance_mask.h"
#include "render/technique/shadow_width/gl/distance_steps.h"
#include "tbb/task_arena.h"

namespace penumbra {

// Shapes  H×W → H·W, row by row
// Units   texels
// Errors  kInvalidArgument: as CheckMask; kCancelled: stop requested, asked once a row
// Cost    O(W·H·log max(W, H))
absl::StatusOr<std::vector<float>> DistanceByStepsOnCpu(const BlockedMask& mask,
                                                        StepNeighbours neighbours,
                                                        tbb::task_arena& arena,
                                                        const std::stop_token& stop);

}  // namespace penumbra
