#include "client/cli/surface_plan.h"

#include <algorithm>
#include <memory>

#include "render/scene/receiver_place.h"
#include "render/scene/texture_size.h"

namespace penumbra {

InstanceTable TableOf(const ImportedScene& imported) {
  InstanceTable table;
  for (const Instance& instance : imported.instances) {
    table[instance.id] = std::make_shared<const Instance>(instance);
  }
  return table;
}

PlanarSurfaceRequest SurfaceRequestFor(const InstanceTable& instances, double min_area_m2,
                                       float texels_per_metre) {
  PlanarSurfaceRequest request{.min_area_m2 = min_area_m2, .texels_per_metre = texels_per_metre};
  if (texels_per_metre > 0.0f) return request;
  const auto largest = FindPlanarSurfaces(instances, min_area_m2, 1);
  if (largest.empty()) return request;
  const auto place =
      PlaceOnSurface(*instances.find(largest[0].instance_id)->second, largest[0].triangle);
  if (!place.ok()) return request;
  const double longer =
      std::max(glm::length(DVec3(place->patch.edge_u)), glm::length(DVec3(place->patch.edge_v)));
  request.texels_per_metre =
      std::min(kMaxTexelsPerMetre, static_cast<float>(kMaxAutoSide / longer));
  return request;
}

}  // namespace penumbra
