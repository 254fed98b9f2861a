// What a request means for a scene file: the scene to commit, and the shadows to ask for.
//
//   auto plan = PlanShadows(*ImportScene(request.scene), request);
//   engine.Commit(scene_id, plan->delta);
//   for (light in plan->light_ids) for (receiver in plan->receiver_ids) …
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cli/commands.h"
#include "client/import/import_scene.h"

namespace penumbra {

struct ShadowPlan {
  SceneDelta delta;  // the file's instances, and of lights and receivers those in use
  std::vector<std::string> light_ids;
  std::vector<std::string> receiver_ids;
  std::vector<std::string> notes;  // what was chosen where the request left it open, one line each
};

// Errors  kNotFound, reason UNKNOWN_ID: no such light or instance in the file; kInvalidArgument,
//         CONFLICT: lights named besides all of them
absl::StatusOr<ShadowPlan> PlanShadows(const ImportedScene& imported, const ShadowRequest& request);

// A patch at the bottom of `bounds`, centred, its edges three times the horizontal ones, front up,
// row 0 at the largest z. A scene of no width gets one of 3 m.
Parallelogram FloorUnder(const Aabb& bounds);

// A rectangle above `bounds` that shines down, as bright as makes a white floor's middle reflect
// radiance 1 with nothing in between.
AreaLight LightAbove(const Aabb& bounds);

// The ids of the instances that may show shadows and are flat, the largest first, at most `count`.
std::vector<std::string> LargestPlanarInstances(const ImportedScene& imported, size_t count);

}  // namespace penumbra
