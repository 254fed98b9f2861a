// What shadow_width's tests compute, and where they look.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "render/scene/scene.h"
#include "render/technique/shadow_width/shadow_width.h"
#include "tbb/task_arena.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {

inline AreaLight Lamp(float side) {
  return {.id = "lamp",
          .shape = RectangleLight{.corner = {-0.5f * side, 3, -0.5f * side},
                                  .edge_u = {side, 0, 0},
                                  .edge_v = {0, 0, side}}};
}

inline Instance Box(std::string id, Vec3 center, Vec3 half) {
  return {.id = std::move(id),
          .mesh = MeshOf(UnitBoxGeometry()),
          .world_from_mesh = Placed(center, half)};
}

inline Instance Ground() {
  return {.id = "ground",
          .mesh = MeshOf(UnitSquareGeometry()),
          .world_from_mesh = Placed(Vec3(0), Vec3(2, 1, 2))};
}

inline absl::StatusOr<Artifact> Compute(const SceneDelta& delta, const ShadowWidthParams& params,
                                        std::vector<Artifact>* passes = nullptr) {
  const auto scene = Scene::Empty("s")->Apply(delta).value();
  tbb::task_arena arena(2);
  ComputeContext context{.arena = arena};
  if (passes) context.progress = [&](Artifact pass) { passes->push_back(std::move(pass)); };
  return ShadowWidth().Compute(*scene, {params, "lamp"}, context);
}

inline float OnFloor(const Artifact& artifact, float x, float z, float y = 0) {
  return Visibility(artifact, Vec3(x, y, z), Vec3(0, 1, 0));
}

}  // namespace penumbra::testing
