// What a shadow-width map is, apart from its texels (width_codec.h), both ways.
#pragma once

#include "absl/status/statusor.h"
#include "penumbra/v1/artifact.pb.h"
#include "render/artifact/shadow_width_map.h"
#include "render/scene/scene_limits.h"

namespace penumbra {

v1::ShadowWidthMap ToProto(const ShadowWidthMap& map);

// The map without texels; which faces have a second layer is told by its being there.
//
// Errors  kInvalidArgument RANGE, NON_FINITE: a view or a constant that cannot be, an image that is
//         empty or larger than `limits` allow, found before anything is allocated
absl::StatusOr<ShadowWidthMap> FromProto(const v1::ShadowWidthMap& proto,
                                         const SceneLimits& limits);

}  // namespace penumbra
