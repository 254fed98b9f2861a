// How many light samples each pass counts, and how good that is.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "render/technique/first_pass.h"

namespace penumbra {

// The first artifact comes after this many samples, or as many as fit into the time budget, each
// later one after this many times more.
inline constexpr uint32_t kFirstPassSamples = 8;
inline constexpr uint32_t kPassGrowth = 8;
// What of a time budget computing may take: the rest is for the way to the client.
inline constexpr double kComputingShare = 0.5;

// Samples of a first pass that is to come within the budget; `pace` may be null.
//
// time_budget_ms  0: there is none
inline uint32_t FirstPassSamples(double time_budget_ms, const FirstPassPace* pace) {
  if (time_budget_ms <= 0 || !pace) return kFirstPassSamples;
  return pace->Samples(kComputingShare * time_budget_ms, kFirstPassSamples);
}

// How many of `n` samples are counted in all after the pass that follows one that ended with
// `done`; 0: none was. A last pass that would bring less than half as many again is merged with the
// one before.
inline uint32_t NextPassEnd(uint32_t done, uint32_t first, uint32_t n) {
  if (done == 0) return std::min(first, n);
  const uint64_t count = uint64_t{done} * kPassGrowth;
  return count + count / 2 >= n ? n : static_cast<uint32_t>(count);
}

// Standard error to expect of the visible fraction by `n` samples, at a straight shadow edge. It
// crosses about √(2n) of the n cells of a jittered grid; the sample in each of these is on the dark
// side with some probability p, which adds p (1 − p) ≤ ¼ to the variance of the count.
//
// has_size  of the light; without, one sample says it all
inline float ErrorEstimate(uint32_t n, bool has_size) {
  if (!has_size) return 0;
  const double crossed = std::min<double>(n, std::sqrt(2.0 * n));
  return static_cast<float>(std::sqrt(0.25 * crossed) / n);
}

}  // namespace penumbra
