// The planar surfaces of a scene's instances, the largest first, and receivers for them.
//
//   for (const FoundSurface& found : FindPlanarSurfaces(scene.instances(), {.min_area_m2 = 0.1}))
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "render/scene/instance.h"
#include "render/scene/receiver.h"
#include "render/scene/scene_limits.h"

namespace penumbra {

// "A receiver for every polygon of this scene": which surfaces, and what their receivers are like.
struct PlanarSurfaceRequest {
  double min_area_m2 = 0.0;       // surfaces of less are left out
  uint32_t max_receivers = 0;     // the largest so many; 0: all
  float texels_per_metre = 0.0f;  // 0: kTexelsPerMetre
  uint32_t max_auto_side = 0;     // texels; 0: kMaxAutoSide
  std::string id_prefix = "surface.";

  friend bool operator==(const PlanarSurfaceRequest&, const PlanarSurfaceRequest&) = default;
};

struct FoundSurface {
  std::string instance_id;
  uint32_t triangle = 0;  // the first of the surface
  double area_m2 = 0.0;   // of its triangles, in the world
};

using InstanceTable = std::map<std::string, std::shared_ptr<const Instance>, std::less<>>;

// The surfaces (planar_surfaces.h) of the instances that receive, by falling area, then by instance
// and triangle: the same instances always give the same list. Surfaces of no area are left out.
//
// Cost  that of PlanarSurfaces for meshes that are new, then O(T + S log S)
std::vector<FoundSurface> FindPlanarSurfaces(const InstanceTable& instances, double min_area_m2,
                                             size_t max_count = std::numeric_limits<size_t>::max());

// PREFIX INSTANCE "." TRIANGLE, or PREFIX HASH "." TRIANGLE with 16 digits of the instance id's
// hash where that would be longer than `max_id_bytes`.
std::string SurfaceReceiverId(const std::string& prefix, const FoundSurface& surface,
                              uint32_t max_id_bytes = SceneLimits{}.max_id_bytes);

// One receiver for each surface that `request` means, named by SurfaceReceiverId.
//
// Errors  kInvalidArgument RANGE, NON_FINITE, BAD_ID; kResourceExhausted QUOTA_RECEIVERS: more than
//         limits.max_receivers, QUOTA_SURFACE_TRIANGLES. Field paths begin with `path`.
absl::StatusOr<std::vector<Receiver>> ReceiversOnSurfaces(const InstanceTable& instances,
                                                          const PlanarSurfaceRequest& request,
                                                          const std::string& path,
                                                          const SceneLimits& limits);

}  // namespace penumbra
