// The planar surfaces of a scene file, as receivers.
//
//   const InstanceTable instances = TableOf(imported);
//   const PlanarSurfaceRequest every = SurfaceRequestFor(instances, min_area_m2, texels_per_metre);
#pragma once

#include "client/import/import_scene.h"
#include "render/scene/surface_receivers.h"

namespace penumbra {

// The file's instances by id.
InstanceTable TableOf(const ImportedScene& imported);

// `texels_per_metre` 0: as many as give the largest surface's longer edge kMaxAutoSide texels, so
// that a ring gets no fewer than a house.
PlanarSurfaceRequest SurfaceRequestFor(const InstanceTable& instances, double min_area_m2,
                                       float texels_per_metre);

}  // namespace penumbra
