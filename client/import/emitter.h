// Meshes that glow, as the lights they stand for.
#pragma once

#include <optional>

#include "render/math/vec.h"
#include "render/scene/area_light.h"
#include "render/scene/instance.h"

namespace penumbra {

// The light that `instance` gives when each of its faces sends out `radiance`: a rectangle where it
// fills a flat parallelogram, a sphere where all its vertices are as far from one point and it
// closes around that; nullopt for any other shape. A rectangle shines from the side that its faces
// turn to (in mesh space: a mirror does not turn them over, as glTF has it), or from both.
std::optional<LightShape> EmitterShape(const Instance& instance, Vec3 radiance, bool two_sided);

}  // namespace penumbra
