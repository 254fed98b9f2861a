// How far a soft shadow of n samples is from the shadow itself.
//
//   const auto errors = PenumbraErrors(scene, {16, 64, 256});
//   FittedExponent(errors)  // −0.75 for samples on a jittered grid
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/scene/scene.h"

namespace penumbra::testing {

struct PenumbraError {
  uint32_t samples = 0;
  double rmse = 0;  // of the visible fraction, over the texels of the penumbra and all seeds
};

// The soft texture of "light" on "receiver" for each count, with `seeds` different jitters, against
// that of 4,096 samples. The penumbra is where the latter is neither 0 nor 1.
std::vector<PenumbraError> PenumbraErrors(const Scene& scene, std::span<const uint32_t> counts,
                                          uint64_t seeds);

// k of the power law rmse ∝ samples^k that fits best, by least squares of the logarithms.
double FittedExponent(std::span<const PenumbraError> errors);

}  // namespace penumbra::testing
