// Making one scene equal to another.
#pragma once

#include "render/scene/scene.h"

namespace penumbra {

// What turns `scene` into one that holds what `wanted` upserts and nothing else. What is there
// already is left out; the result may be empty.
SceneDelta ReplacementDelta(const Scene& scene, const SceneDelta& wanted);

}  // namespace penumbra
