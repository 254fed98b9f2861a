#include "render/technique/soft_texture/params_check.h"

#include <algorithm>
#include <string_view>

#include "absl/strings/str_cat.h"
#include "render/math/float_text.h"
#include "render/scene/field_error.h"
#include "render/scene/scene_limits.h"
#include "render/technique/soft_texture/all_lights.h"
#include "render/technique/spec_check.h"

namespace penumbra {
namespace {

absl::Status RangeError(std::string_view field, const std::string& found, std::string_view need) {
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", field,
                    absl::StrCat("found ", found, ", need ", std::string(need)));
}

std::string Text(Vec3 rgb) {
  return absl::StrCat(FloatText(rgb.x), " ", FloatText(rgb.y), " ", FloatText(rgb.z));
}

template <size_t kCount>
std::string NameOf(const std::array<std::string_view, kCount>& names, auto value) {
  return std::string(names[static_cast<size_t>(value)]);
}

}  // namespace

absl::Status CheckParams(const SoftTextureParams& params) {
  const uint32_t most = SceneLimits{}.max_light_samples;
  if (params.samples < 1 || params.samples > most) {
    return RangeError("soft_texture.samples", absl::StrCat(params.samples),
                      absl::StrCat("1 to ", most));
  }
  if (params.silhouette_reuse < 1 || params.silhouette_reuse > kMaxSilhouetteReuse) {
    return RangeError("soft_texture.silhouette_reuse", absl::StrCat(params.silhouette_reuse),
                      absl::StrCat("1 to ", kMaxSilhouetteReuse));
  }
  if (params.silhouette_reuse > 1 && !BorrowsOutlines(params)) {
    return RangeError("soft_texture.silhouette_reuse",
                      absl::StrCat(params.silhouette_reuse, " with the method ",
                                   std::string(NameOf(params.method))),
                      "1, or the method auto or silhouette");
  }
  if (!(params.form_factor_error >= 0 && params.form_factor_error <= kMaxFormFactorError)) {
    return RangeError("soft_texture.form_factor_error", absl::StrCat(params.form_factor_error),
                      absl::StrCat("0 to ", kMaxFormFactorError));
  }
  const Vec3 ambient = params.ambient;
  if (!IsFinite(ambient) || !(std::min({ambient.x, ambient.y, ambient.z}) >= 0)) {
    return RangeError("soft_texture.ambient", Text(ambient), "finite numbers of at least 0");
  }
  if (!(params.output_scale >= 0 && params.output_scale <= kMaxOutputScale)) {
    return RangeError("soft_texture.output_scale", absl::StrCat(params.output_scale),
                      absl::StrCat("0 to ", kMaxOutputScale));
  }
  return absl::OkStatus();
}

absl::Status CheckCountBits(const SoftTextureParams& params, size_t samples) {
  if (params.count_bits != CountBits::k8 || samples <= 255) return absl::OkStatus();
  return RangeError("soft_texture.count_bits", absl::StrCat("8 for ", samples, " light samples"),
                    "16 or auto, or at most 255 samples");
}

absl::Status CheckSpec(const Scene& scene, const ArtifactSpec& spec) {
  const auto& params = std::get<SoftTextureParams>(spec.params);
  if (const auto status = CheckParams(params); !status.ok()) return status;
  if (const auto status = CheckTarget(spec); !status.ok()) return status;
  if (const auto status = CheckTimeBudget(spec); !status.ok()) return status;
  if (spec.light_id == kAllLights) {
    const auto status = CheckAllLights(scene, params);
    return status.ok() ? scene.ResolveReceiver(spec.receiver_id).status() : status;
  }
  if (const auto status = CheckOneLight(scene, spec.light_id); !status.ok()) return status;
  const uint32_t samples = EffectiveSampleCount(*scene.FindLight(spec.light_id), params.samples);
  if (const auto status = CheckCountBits(params, samples); !status.ok()) return status;
  return scene.ResolveReceiver(spec.receiver_id).status();
}

std::map<std::string, std::string> EffectiveParameters(const SoftTextureParams& params,
                                                       size_t samples) {
  std::map<std::string, std::string> text = {{"samples", absl::StrCat(samples)},
                                             {"seed", absl::StrCat(params.seed)},
                                             {"radiance", params.radiance ? "true" : "false"},
                                             {"method", std::string(NameOf(params.method))}};
  if (BorrowsOutlines(params)) {
    text["silhouette_reuse"] = absl::StrCat(params.silhouette_reuse);
  }
  if (params.radiance) {
    // OpenGL adds up the samples whatever is asked for.
    const bool by_gl = params.method == VisibilityMethod::kGl;
    text["shading"] = NameOf(kShadingNames, by_gl ? Shading::kSampleSum : params.shading);
    text["form_factor_error"] = FloatText(params.form_factor_error);
    text["ambient"] = Text(params.ambient);
    text["output"] = NameOf(kRadianceFormatNames, params.output);
  }
  return text;
}

}  // namespace penumbra
