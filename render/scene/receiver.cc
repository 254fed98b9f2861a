#include "render/scene/receiver.h"

#include "render/scene/receiver_place.h"

namespace penumbra {

const std::string* InstanceOf(const Receiver& receiver) {
  if (const auto* planar = std::get_if<PlanarInstance>(&receiver.shape)) {
    return &planar->instance_id;
  }
  const auto* surface = std::get_if<PlanarSurface>(&receiver.shape);
  return surface == nullptr ? nullptr : &surface->instance_id;
}

bool operator==(const ReceiverPatch& a, const ReceiverPatch& b) {
  const bool same_region = a.region == b.region || (a.region && b.region && *a.region == *b.region);
  return a.patch == b.patch && a.width == b.width && a.height == b.height &&
         a.two_sided == b.two_sided && a.reflectance == b.reflectance && same_region &&
         a.deviation_m == b.deviation_m;
}

DVec2 UvOnPatch(const Parallelogram& patch, DVec3 point) {
  const DVec3 u(patch.edge_u), v(patch.edge_v), d = point - DVec3(patch.origin);
  const double uu = glm::dot(u, u), uv = glm::dot(u, v), vv = glm::dot(v, v);
  const double du = glm::dot(d, u), dv = glm::dot(d, v);
  const double det = uu * vv - uv * uv;
  return {(du * vv - dv * uv) / det, (dv * uu - du * uv) / det};
}

absl::StatusOr<Parallelogram> BoundingParallelogram(const Instance& instance) {
  const auto place = PlaceOnInstance(instance);
  if (!place.ok()) return place.status();
  return place->patch;
}

}  // namespace penumbra
