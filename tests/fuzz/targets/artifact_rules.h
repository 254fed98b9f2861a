// What render/artifact says of artifacts, as checks.
#pragma once

#include "render/artifact/artifact.h"
#include "render/scene/scene_limits.h"

namespace penumbra::fuzzing {

// Sizes, counts and indices. Ends the process where they are not as they should be.
void RequireRules(const Artifact& artifact, const SceneLimits& limits);

// Visibility at points near and far, in [0, 1].
void RequireLookups(const Artifact& artifact);

}  // namespace penumbra::fuzzing
