// Lights, both ways.
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "penumbra/v1/scene.pb.h"
#include "render/scene/area_light.h"

namespace penumbra {

v1::Light ToProto(const AreaLight& light);

// Numbers are taken as they are: Scene::Apply checks them.
//
// Errors  kInvalidArgument MISSING_FIELD: no shape, or one of a later protocol
absl::StatusOr<AreaLight> FromProto(const v1::Light& light, std::string_view field_path);

}  // namespace penumbra
