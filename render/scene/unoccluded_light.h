// Direct light where nothing is in the way, in closed form for every kind of light.
#pragma once

#include "render/math/vec.h"
#include "render/scene/area_light.h"

namespace penumbra {

// Radiance that a white diffuse surface at `point` reflects when all of `light` is visible:
//
//   L = F · L_light  (rectangle, disk, sphere),   L = E / π  (point, spot, distant)
//
// where F is the form factor ∫ cos θ cos θ' / (π r²) dA', with the part of the light below the
// surface's horizon left out. Never negative, never NaN.
//
// Units   `normal` of length 1; W·m⁻²·sr⁻¹
// Source  Herf 1997, equations 3.1, 4.1 and 4.2
Vec3 UnoccludedRadiance(const AreaLight& light, Vec3 point, Vec3 normal);

// Its two factors: the radiance, intensity or irradiance that `light` is given with, and what a
// unit of that does at `point`.
Vec3 LightStrength(const AreaLight& light);
double UnoccludedFactor(const AreaLight& light, DVec3 point, DVec3 normal);

// The part of its intensity that a spot sends along a unit vector, in [0, 1]: the square of a ramp
// that is linear in the cosine, as in KHR_lights_punctual.
struct SpotCone {
  explicit SpotCone(const SpotLight& light);
  double Falloff(DVec3 direction) const;

  DVec3 axis;
  double cos_outer, cos_inner;
};

}  // namespace penumbra
