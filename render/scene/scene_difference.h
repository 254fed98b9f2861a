// What one scene has that another has not.
#pragma once

#include "render/scene/scene.h"

namespace penumbra {

// What turns `from` into `to`. Tables and objects that both share are not looked into.
SceneDelta Difference(const Scene& from, const Scene& to);

}  // namespace penumbra
