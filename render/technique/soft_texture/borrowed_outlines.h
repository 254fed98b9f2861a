// Outlines that light samples borrow from a neighbour, as an option: what is seen of a mesh changes
// little from one sample to the next, and finding it takes time.
//
// Source  Herf 1997, §4.4.2: silhouettes reused across samples
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "render/scene/coverage_mask.h"
#include "render/scene/light_sample.h"
#include "render/technique/soft_texture/kept_shadows.h"
#include "render/technique/soft_texture/occlusion_counter.h"

namespace penumbra {

// For each of `samples` the one whose outlines it is drawn with: groups of up to `group_size`
// neighbours on the light use those of the one nearest to their middle.
//
// Shapes  n samples → n samples
std::vector<LightSample> OutlineLenders(std::span<const LightSample> samples, uint32_t group_size);

// The numbers of up to `most` samples that are furthest from their lenders, where borrowing is
// worst.
std::vector<uint32_t> FurthestFromLenders(std::span<const LightSample> samples,
                                          std::span<const LightSample> lenders, size_t most);

// The largest part of the texels `inside`, or of all, that a light sample sees wrongly: of those
// few samples that are furthest from their lenders, each drawn exactly by one new counter and with
// borrowed outlines by the other.
//
// Errors  kCancelled: stop requested
absl::StatusOr<double> BorrowingError(OcclusionCounter& exact, OcclusionCounter& borrowing,
                                      std::span<const LightSample> samples,
                                      std::span<const LightSample> lenders,
                                      const CoverageMask* inside, const ReceiverPatch& receiver,
                                      tbb::task_arena& arena, const std::stop_token& stop);

// The largest part of a texture's texels, of those `inside` if it is not null, that one of `count`
// samples hides in one and not in the other.
double LargestDifference(const SampleShadows& a, const SampleShadows& b, uint32_t count,
                         uint32_t width, uint32_t height, const CoverageMask* inside);

}  // namespace penumbra
