// How a light sees a scene, both ways.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "penumbra/v1/artifact.pb.h"
#include "render/artifact/light_view.h"
#include "render/scene/scene_limits.h"

namespace penumbra {

v1::LightView ToProto(const LightView& view);
LightView FromProto(const v1::LightView& proto);

// Errors  kInvalidArgument, at `field`: NON_FINITE; RANGE: an empty window, an image that is empty
//         or larger than `limits` allow
absl::Status CheckView(const LightView& view, const std::string& field, const SceneLimits& limits);

// Errors  kInvalidArgument RANGE, at `field`: more views than a light has
absl::Status CheckFaceCount(int count, const std::string& field);

}  // namespace penumbra
