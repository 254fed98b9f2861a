// The scene that most cases measure: a floor of 10 m under a lamp, and boxes between them.
#pragma once

#include <cstdint>

#include "render/scene/scene.h"

namespace penumbra::bench {

// The receiver "floor" of `texels` × `texels` and the rectangle light "lamp" 8 m above it.
SceneDelta Studio(uint32_t texels);

// The same with `count` boxes "box0", "box1", … of 0.1 to 0.5 m, turned every way, anywhere between
// floor and lamp; the same ones each time.
SceneDelta Boxes(int count, uint32_t texels);

}  // namespace penumbra::bench
