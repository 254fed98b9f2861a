// The shadow of a caster by its own edges, as exact as its triangles.
//
//   ShadowVolume volume = SilhouetteVolume(instance, light);
#pragma once

#include "render/artifact/shadow_volume_mesh.h"
#include "render/scene/area_light.h"
#include "render/scene/instance.h"

namespace penumbra {

// Walls from the outline's edges away from the light's centre, without end, and the caster's
// triangles to close them with. Crossing a wall changes the number of surfaces between the light
// and the place by 2 where two faces meet and by 1 at the edge of one: with these weights open
// meshes, and edges of three faces, count as they should.
//
// The mask is not asked for: a masked caster has its whole shape's shadow.
//
// Cost    O(edges)
// Source  Bergeron 1986, after McCool 2000, §1.3 and §8.2
ShadowVolume SilhouetteVolume(const Instance& instance, const AreaLight& light);

}  // namespace penumbra
