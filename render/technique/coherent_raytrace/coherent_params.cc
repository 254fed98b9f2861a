#include "render/technique/coherent_raytrace/coherent_params.h"

#include <cmath>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/math/float_text.h"
#include "render/scene/field_error.h"
#include "render/scene/light_sample.h"
#include "render/scene/scene_limits.h"

namespace penumbra {
namespace {

absl::Status RangeError(std::string_view name, const std::string& found, const std::string& need) {
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE",
                    absl::StrCat("coherent_raytrace.", std::string(name)),
                    absl::StrCat("found ", found, ", need ", need));
}

std::string NameOf(RadianceFormat format) {
  return std::string(kRadianceFormatNames[static_cast<size_t>(format)]);
}

const char* TextOf(bool value) { return value ? "true" : "false"; }

}  // namespace

absl::Status CheckParams(const CoherentRaytraceParams& params) {
  const uint32_t most = SceneLimits{}.max_light_samples;
  if (params.samples < 1 || params.samples > most) {
    return RangeError("samples", absl::StrCat(params.samples), absl::StrCat("1 to ", most));
  }
  if (params.resolution < 1 || params.resolution > kMaxReferenceResolution) {
    return RangeError("resolution", absl::StrCat(params.resolution),
                      absl::StrCat("1 to ", kMaxReferenceResolution));
  }
  if (IsUnorm(params.output)) return RangeError("output", NameOf(params.output), "float32 or half");
  for (const auto& [name, value] :
       {std::pair<std::string_view, float>{"prediction_distance", params.prediction_distance},
        {"gap_bias", params.gap_bias},
        {"shadow_bias", params.shadow_bias}}) {
    if (!(std::isfinite(value) && value >= 0)) {
      return RangeError(name, absl::StrCat(value), "a number of at least 0");
    }
  }
  return absl::OkStatus();
}

uint32_t SideOf(const CoherentRaytraceParams& params, const AreaLight& light) {
  if (EffectiveSampleCount(light, 2) < 2) return 1;
  uint32_t side = 1;
  while ((side + 1) * (side + 1) <= params.samples) ++side;
  return side;
}

std::map<std::string, std::string> EffectiveParameters(const CoherentRaytraceParams& params,
                                                       uint32_t side, float shadow_bias,
                                                       float prediction_distance) {
  const bool by_images = params.backend == RayBackend::kDepthImages;
  std::map<std::string, std::string> text = {
      {"samples", absl::StrCat(side * side)},
      {"seed", absl::StrCat(params.seed)},
      {"backend", by_images ? "depth_images" : "triangles"},
      {"radiance", TextOf(params.radiance)},
      {"coherence", TextOf(params.coherence)},
      {"prediction_distance", FloatText(prediction_distance)}};
  if (params.radiance) text["output"] = NameOf(params.output);
  if (params.shadow_bias > 0 || !by_images) {
    text["shadow_bias"] = FloatText(shadow_bias);
  }
  if (by_images) {
    text["resolution"] = absl::StrCat(params.resolution);
    text["whole_light"] = TextOf(params.whole_light);
    text["ray_accelerations"] = TextOf(params.ray_accelerations);
    if (params.gap_bias > 0) text["gap_bias"] = FloatText(params.gap_bias);
  }
  return text;
}

}  // namespace penumbra
