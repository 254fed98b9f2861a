#include "render/technique/shadow_volume/silhouette_volume.h"

#include <utility>
#include <variant>
#include <vector>

#include "render/artifact/light_extent.h"
#include "render/scene/silhouette_edges.h"

namespace penumbra {
namespace {

// Homogeneous: a position, or the direction towards it.
}  // namespace

ShadowVolume SilhouetteVolume(const Instance& instance, const AreaLight& light) {
  ShadowVolume volume{.kind = VolumeKind::kObject};
  const DVec4 place = PlaceOfMiddle(light);
  // In the world: a map of the mesh may turn faces over, or flatten them.
  std::vector<Vec3> positions;
  for (const Vec3& p : instance.mesh->positions()) {
    positions.push_back(TransformPoint(instance.world_from_mesh, p));
  }
  const auto indices = instance.mesh->indices();
  SilhouetteList outline;
  SilhouetteEdges(positions, indices).Find(place, outline);
  for (const Vec3& p : positions) volume.vertices.emplace_back(p, 1.0f);
  const auto count = static_cast<uint32_t>(positions.size());
  // Where light goes on to from a vertex: position − light, at infinity.
  for (const Vec3& p : positions) {
    volume.vertices.emplace_back(Vec3(place.w * DVec3(p) - DVec3(place)), 0.0f);
  }
  volume.caster_indices.assign(indices.begin(), indices.end());
  for (size_t i = 0; i < outline.count; ++i) {
    const uint32_t from = outline.from[i], to = outline.to[i];
    const auto weight = static_cast<int8_t>(-outline.weight[i]);
    volume.indices.insert(volume.indices.end(),
                          {from, to, to + count, from, to + count, from + count});
    volume.weights.insert(volume.weights.end(), {weight, weight});
  }
  return volume;
}

}  // namespace penumbra
