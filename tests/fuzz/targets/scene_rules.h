// What render/scene says of scenes, as checks.
#pragma once

#include "render/scene/content_hash.h"
#include "render/scene/scene.h"
#include "render/scene/scene_limits.h"

namespace penumbra::fuzzing {

// The hash anew, from the objects alone.
ContentHash HashAnew(const Scene& scene);

// Ends the process where the scene's hash is not that of its content, where it is over a limit, or
// where what is in it is not as a commit makes it.
void RequireRules(const Scene& scene, const SceneLimits& limits);

}  // namespace penumbra::fuzzing
