#include "tests/support/scenes_on_floors.h"

#include <algorithm>
#include <utility>

#include "client/import/import_scene.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

absl::StatusOr<std::shared_ptr<const Scene>> WithFloor(std::vector<Instance> instances) {
  Aabb bounds;
  for (const Instance& instance : instances) bounds.Add(WorldBounds(instance));
  const Vec3 extent = bounds.extent(), center = bounds.center();
  const float width = std::max({extent.x, extent.z, 0.5f * extent.y});
  SceneDelta delta{.upsert_instances = std::move(instances)};
  const Vec3 below(center.x, bounds.min.y, center.z);
  delta.upsert_instances.push_back({.id = "floor",
                                    .mesh = MeshOf(UnitSquareGeometry()),
                                    .world_from_mesh = Placed(below, 1.5f * width)});
  const float side = 0.5f * width;
  const Vec3 above(center.x, bounds.max.y + width, center.z);
  delta.upsert_lights = {
      {.id = "lamp",
       .shape = RectangleLight{.corner = above - Vec3(0.5f * side, 0, 0.5f * side),
                               .edge_u = {side, 0, 0},
                               .edge_v = {0, 0, side},
                               .two_sided = false}}};
  return Scene::Empty("on-floor")->Apply(delta);
}

}  // namespace

absl::StatusOr<std::shared_ptr<const Scene>> LoadOnFloor(const std::filesystem::path& file) {
  auto imported = ImportScene(file);
  if (!imported.ok()) return imported.status();
  return WithFloor(std::move(imported->instances));
}

std::shared_ptr<const Scene> OnFloor(std::vector<Instance> instances) {
  return WithFloor(std::move(instances)).value();
}

}  // namespace penumbra::testing
