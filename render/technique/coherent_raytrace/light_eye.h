// What is seen from one point of a light, in one image or, of lights that shine all around, in
// several.
//
//   for (const Vec3& place : LightVertices(light)) ViewsFrom(light, scene, place, 1024);
#pragma once

#include <cstdint>
#include <vector>

#include "render/artifact/light_view.h"
#include "render/scene/scene.h"

namespace penumbra {

struct EyeView {
  LightView view;
  bool covers_all;  // nothing that casts is beyond its edges
};

// Just large enough for all that casts.
//
// place   a position, or of distant lights a unit direction to the light
// pixels  along the longer side of each image
std::vector<EyeView> ViewsFrom(const AreaLight& light, const Scene& scene, Vec3 place,
                               uint32_t pixels);

// A rectangle's corners, four points around a disk or the disc of a distant light, six of a sphere,
// the place of a light without extent.
std::vector<Vec3> LightVertices(const AreaLight& light);

}  // namespace penumbra
