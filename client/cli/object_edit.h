// Edits of single objects, as people ask for them.
//
//   auto delta = MoveObject(*scene, "lamp", {0.5f, 0, 0});
//   engine.Commit(scene_id, *delta);
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "render/scene/scene.h"

namespace penumbra {

// The instance, the light, or both, of that id: an importer calls a light as the glowing instance
// that it stands for.
//
// Errors  kNotFound UNKNOWN_ID: neither; kInvalidArgument NO_PLACE: a light that is infinitely far
absl::StatusOr<SceneDelta> MoveObject(const Scene& scene, const std::string& id, Vec3 by);

// Gives the light another radiance, intensity or irradiance, whichever it has.
//
// Errors  kNotFound UNKNOWN_ID: no such light
absl::StatusOr<SceneDelta> SetLightStrength(const Scene& scene, const std::string& id, Vec3 rgb);

// Instance, light and receiver of that id.
//
// Errors  kNotFound UNKNOWN_ID: none of them
absl::StatusOr<SceneDelta> RemoveObject(const Scene& scene, const std::string& id);

}  // namespace penumbra
