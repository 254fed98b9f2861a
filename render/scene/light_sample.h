// Points on a light at which its visibility is tested.
#pragma once

#include <cstdint>
#include <vector>

#include "render/math/vec.h"
#include "render/scene/area_light.h"

namespace penumbra {

struct LightSample {
  Vec3 point{0.0f};          // position in world space, or unit direction towards the light
  bool at_infinity = false;  // `point` is a direction
  float weight = 1.0f;       // share of the light that this sample stands for; all sum to 1

  friend bool operator==(const LightSample&, const LightSample&) = default;
};

// How many samples `light` gets when `count` are asked for: points and discs of no size need one.
uint32_t EffectiveSampleCount(const AreaLight& light, uint32_t count);

// A jittered grid of EffectiveSampleCount(light, count) cells of equal area, one sample a cell, in
// an order whose every prefix is well spread. The same arguments give the same bits. Spheres are
// sampled on the half that faces `target`.
//
// Shapes  count in [1, 1024] → n samples, n ≤ count
// Source  Herf 1997, §4.5.1
std::vector<LightSample> SampleLight(const AreaLight& light, uint32_t count, uint64_t seed,
                                     Vec3 target);

}  // namespace penumbra
