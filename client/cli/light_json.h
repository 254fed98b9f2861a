// Lights as JSON, the fields named as in render/scene/area_light.h.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "render/scene/area_light.h"

namespace penumbra {

nlohmann::ordered_json LightToJson(const AreaLight& light);

}  // namespace penumbra
