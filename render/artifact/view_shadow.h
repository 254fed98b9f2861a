// The shadow of one light at points on surfaces: a camera's pixels, a lightmap's texels, or points
// that somebody gave.
#pragma once

#include <cstdint>

#include "render/artifact/shadow_texels.h"
#include "render/scene/area_light.h"
#include "render/scene/point_receiver.h"

namespace penumbra {

// How far a pass of many has come.
struct ShadingProgress {
  double fraction_done = 1.0;  // of the points, in [0, 1]
  uint64_t rays_traced = 0;
  double time_left_ms = 0.0;  // at the pace so far; 0: nothing is left, or nothing is known yet
};

// H×W points as GridOf(points) says. Those outside of the mask have no surface or, before the last
// pass, are still to come. `radiance` is what a white diffuse surface would reflect there: the
// irradiance over π (Agrawala et al. 2000, equation 1); the counts are out of the light's samples
// before the point, all of the same weight (equation 2).
struct ViewShadow : ShadowTexels {
  PointReceiver points;
  AreaLight light;
  ShadingProgress progress;
};

}  // namespace penumbra
