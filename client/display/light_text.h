// A light as one line of text, for files that have room for text alone: its kind, and all of its
// numbers to the last bit.
//
//   LightFromText(LightText(light))   // the same light
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "render/scene/area_light.h"

namespace penumbra {

std::string LightText(const AreaLight& light);

// Errors  kInvalidArgument: no light
absl::StatusOr<AreaLight> LightFromText(std::string_view text);

}  // namespace penumbra
