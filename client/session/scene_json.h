// A scene as text that programs read.
#pragma once

#include <string>

#include "render/scene/scene.h"

namespace penumbra {

// A v1.SceneDelta from the empty scene in protobuf's JSON, with the fields named as in the protocol
// and every one of them written; objects in the order of their ids.
std::string SceneJson(const Scene& scene);

}  // namespace penumbra
