// Parameters of coherent_raytrace: what is allowed, and what was effective.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "absl/status/status.h"
#include "render/scene/area_light.h"
#include "render/technique/coherent_raytrace/coherent_raytrace_params.h"

namespace penumbra {

// Errors  kInvalidArgument RANGE, which names the field as "coherent_raytrace.samples"
absl::Status CheckParams(const CoherentRaytraceParams& params);

// Cells along a side of the light; 1 of a light without a size.
uint32_t SideOf(const CoherentRaytraceParams& params, const AreaLight& light);

// As text, for an artifact's header, with what was chosen.
std::map<std::string, std::string> EffectiveParameters(const CoherentRaytraceParams& params,
                                                       uint32_t side, float shadow_bias,
                                                       float prediction_distance);

}  // namespace penumbra
