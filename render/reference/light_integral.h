// Direct light where nothing is in the way, by integrating over the light: the oracle for
// UnoccludedRadiance. It shares neither formulas nor code with the closed forms.
#pragma once

#include "render/math/vec.h"
#include "render/scene/area_light.h"

namespace penumbra {

// Radiance that a white diffuse surface at `point`, outside of the light, reflects:
//
//   L = 1/π ∫ L_light max(0, cos θ) dω
//
// Rectangles in their own coordinates, disks in polar ones, both as cos θ cos θ' / r² dA; spheres
// and distant discs over the cone of directions that they fill. The inner integrand is linear in
// cos θ's numerator and is cut where that crosses the horizon, the outer one where the horizon
// crosses an edge.
//
// Accuracy  relative error below 1e-8 at distances from a hundredth of the light's size
DVec3 IntegratedRadiance(const AreaLight& light, DVec3 point, DVec3 normal);

}  // namespace penumbra
