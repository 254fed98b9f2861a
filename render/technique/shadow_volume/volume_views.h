// Where a light looks for the boundary of its shadow.
//
//   const double pitch = PitchFor(light, bounds, 512);
//   for (const VolumeView& view : VolumeViews(light, boxes, pitch)) …
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/artifact/volume_grid.h"
#include "render/math/aabb.h"
#include "render/scene/area_light.h"

namespace penumbra {

struct VolumeView {
  LightView view;
  VolumeBorder border = VolumeBorder::kNothing;
};

// Slope, or metres, from sample to sample that gives a light's view of `bounds` `resolution` of
// them along its longer side; of six views, each. 0 where the light sees nothing of them.
double PitchFor(const AreaLight& light, const Aabb& bounds, uint32_t resolution);

// One view from the middle of `light` that holds the boxes, or six that see all around, along the
// world's axes both ways: x, y, z. These have samples where slopes are ±1, so that each of a cube's
// edges is a row of samples of both its faces. None where there is nothing to see.
//
// A point or sphere looks towards the middle of the boxes if it sees all within kMaxSlope of there,
// other lights as FacesOf() has them if one face is enough.
//
// Source  McCool 2000, §5
std::vector<VolumeView> VolumeViews(const AreaLight& light, std::span<const Aabb> boxes,
                                    double pitch);

// Has the maps of six views, in the order of VolumeViews, tell the same of the rows of samples that
// they share: what the first of them says.
void JoinBorders(std::span<DepthMap> maps);

}  // namespace penumbra
