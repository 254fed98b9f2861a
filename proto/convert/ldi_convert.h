// What a layered attenuation map is, apart from its layers (ldi_codec.h), both ways.
#pragma once

#include "absl/status/statusor.h"
#include "penumbra/v1/artifact.pb.h"
#include "render/artifact/attenuation_ldi.h"
#include "render/scene/scene_limits.h"

namespace penumbra {

v1::AttenuationLdi ToProto(const AttenuationLdi& ldi);

// The map without any layers.
//
// Errors  kInvalidArgument RANGE, NON_FINITE: a view that cannot be, an image that is empty or
//         larger than `limits` allow, found before anything is allocated
absl::StatusOr<AttenuationLdi> FromProto(const v1::AttenuationLdi& proto,
                                         const SceneLimits& limits);

}  // namespace penumbra
