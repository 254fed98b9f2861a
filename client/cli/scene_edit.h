// The edits that the demonstration makes.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "render/scene/scene.h"

namespace penumbra {

// Moves the instance that blocks the most: of those that cast and are not flat, the one whose box
// is largest without being most of the scene; or any that casts. It goes a third of its width along
// x.
//
// Errors  kFailedPrecondition: nothing casts
absl::StatusOr<SceneDelta> MoveAnObject(const Scene& scene);

// Moves the brightest light sideways by a fifth of the scene's width, and with it the glowing
// instance of the same id, if there is one; the sun moves in the sky.
//
// Errors  kFailedPrecondition: no light
absl::StatusOr<SceneDelta> MoveTheLamp(const Scene& scene);

}  // namespace penumbra
