// What a request means for a scene file: the scene to commit, and the shadows to ask for.
//
//   auto plan = PlanShadows(*ImportScene(request.scene), request);
//   engine.Commit(scene_id, plan->delta);
//   for (const PlannedShadow& shadow : ShadowsOf(*plan, request.params)) …
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cli/commands.h"
#include "client/cli/point_plan.h"
#include "client/import/import_scene.h"
#include "render/technique/artifact_spec.h"

namespace penumbra {

struct ShadowPlan {
  SceneDelta delta;  // the file's instances, and of lights and receivers those in use
  std::vector<std::string> light_ids;
  std::vector<std::string> receiver_ids;  // of a technique for receivers
  std::vector<PlannedPoints> points;      // of a technique for points
  std::vector<std::string> notes;  // what was chosen where the request left it open, one line each
};

// The request has passed CheckOptionsFit.
//
// For techniques that compute on all surfaces, or at points, the floor is an instance, which casts
// and is seen; for others it is a receiver.
//
// Errors  kNotFound, reason UNKNOWN_ID: no such light or instance in the file; kInvalidArgument,
//         CONFLICT: lights named besides all of them; those of PlanPoints
absl::StatusOr<ShadowPlan> PlanShadows(const ImportedScene& imported, const ShadowRequest& request);

// A patch at the bottom of `bounds`, centred, its edges three times the horizontal ones, front up,
// row 0 at the largest z. A scene of no width gets one of 3 m.
Parallelogram FloorUnder(const Aabb& bounds);

// A rectangle above `bounds` that shines down, as bright as makes a white floor's middle reflect
// radiance 1 with nothing in between.
AreaLight LightAbove(const Aabb& bounds);

struct PlannedShadow {
  ArtifactSpec spec;
  // What it is computed for, followed by its light where there are several: "floor.lamp". Of a
  // technique for all surfaces the light's alone.
  std::string name;
};

// All that the plan wants: what is computed for by what is computed for, the lights of each.
std::vector<PlannedShadow> ShadowsOf(const ShadowPlan& plan, const TechniqueParams& params);

// The ids of the instances that may show shadows and are flat, the largest first, at most `count`.
std::vector<std::string> LargestPlanarInstances(const ImportedScene& imported, size_t count);

}  // namespace penumbra
