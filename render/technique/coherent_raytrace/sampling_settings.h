// How the light is sampled at each point.
#pragma once

#include <cstdint>

namespace penumbra {

struct SamplingSettings {
  uint32_t side = 16;  // cells along each side of the light, one sample a cell: 1 … 32
  uint64_t seed = 0;
  // Off: every cell of every point is traced.
  bool predicts = true;
  // A blocker in the part of a cell that its sample is in stands for the sample's ray.
  bool skips_known_rays = true;
  // A cell at the light's edge that is predicted like its neighbours is traced at each point (1) or
  // at one in so many, each at another one: at least 1.
  uint32_t exterior_turns = 2;
  uint32_t parts = 3;  // of a cell's side; one blocker is kept for each part: 1 … 4
  // From a point further than this from the one before nothing is predicted, in m.
  float prediction_distance = 0.0f;
};

}  // namespace penumbra
