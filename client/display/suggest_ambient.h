// How bright a picture's ambient light is where nobody says.
#pragma once

#include "render/math/vec.h"
#include "render/scene/scene.h"

namespace penumbra {

// Radiance that lifts what no light reaches out of black: a share of the light there is; 1 where
// there is none at all.
Vec3 SuggestAmbient(const Scene& scene);

}  // namespace penumbra
