// What a scene's objects count in its content hash.
#pragma once

#include "render/scene/area_light.h"
#include "render/scene/content_hash.h"
#include "render/scene/instance.h"
#include "render/scene/receiver.h"

namespace penumbra {

// Equal for equal objects, −0 and 0 being one.
ContentHash HashOf(const Instance& instance);
ContentHash HashOf(const AreaLight& light);
ContentHash HashOf(const Receiver& receiver);

}  // namespace penumbra
