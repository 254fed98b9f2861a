#include "render/technique/artifact_spec.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "render/scene/field_error.h"
#include "render/scene/scene.h"

namespace penumbra {
namespace {

// Floats to the last bit.
std::string KeyOfShading(const SoftTextureParams& params) {
  const Vec3 ambient = params.ambient;
  return absl::StrFormat("%d %a %a %a %a %d %a %d", static_cast<int>(params.shading),
                         params.form_factor_error, ambient.x, ambient.y, ambient.z,
                         static_cast<int>(params.output), params.output_scale,
                         static_cast<int>(params.count_bits));
}

std::string KeyOf(const SoftTextureParams& params) {
  return absl::StrCat(params.samples, " ", params.seed, " ", params.radiance, " ",
                      static_cast<int>(params.method), " ", params.silhouette_reuse, " ",
                      KeyOfShading(params));
}

std::string KeyOf(const LayeredAttenuationParams& params) {
  return absl::StrFormat("%d %d %d %a %d %d %d", params.samples, params.seed, params.resolution,
                         params.tolerance, static_cast<int>(params.source), params.key_views,
                         params.max_layers);
}

std::string KeyOf(const CoherentRaytraceParams& params) {
  return absl::StrFormat("%d %d %d %d %d %d %d %d %a %d %a %a", params.samples, params.seed,
                         static_cast<int>(params.backend), params.radiance,
                         static_cast<int>(params.output), params.coherence, params.whole_light,
                         params.ray_accelerations, params.prediction_distance, params.resolution,
                         params.gap_bias, params.shadow_bias);
}

std::string KeyOf(const ShadowWidthParams& params) {
  return absl::StrFormat("%d %d %d %d %a %a %d", params.resolution,
                         static_cast<int>(params.distance), params.layers,
                         static_cast<int>(params.blocker_depth), params.c_scale, params.c_bias,
                         static_cast<int>(params.source));
}

std::string KeyOf(const ShadowVolumeParams& params) {
  return absl::StrFormat("%d %a %a %a %d %d %d %d", params.resolution, params.bias,
                         params.low_threshold, params.high_threshold,
                         static_cast<int>(params.surface), static_cast<int>(params.volumes_of),
                         params.object_ids, static_cast<int>(params.source));
}

std::string NameOf(const ArtifactSpec& spec) { return std::string(InfoOf(spec.params).name); }

absl::Status Unexpected(const ArtifactSpec& spec, std::string_view field) {
  return FieldError(absl::StatusCode::kInvalidArgument, "UNEXPECTED_FIELD", field,
                    absl::StrCat("found one, need none for ", NameOf(spec)));
}

}  // namespace

absl::Status CheckTimeBudget(const ArtifactSpec& spec) {
  if (std::isfinite(spec.time_budget_ms) && spec.time_budget_ms >= 0) return absl::OkStatus();
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", "time_budget_ms",
                    absl::StrCat("found ", spec.time_budget_ms, ", need a number >= 0"));
}

absl::Status CheckTarget(const ArtifactSpec& spec, const SceneLimits& limits) {
  const SpecTarget target = InfoOf(spec.params).target;
  if (target != SpecTarget::kPoints && spec.points) return Unexpected(spec, "points");
  if (target == SpecTarget::kReceiver) return CheckId(spec.receiver_id, "receiver_id");
  if (!spec.receiver_id.empty()) return Unexpected(spec, "receiver_id");
  if (target == SpecTarget::kScene) return absl::OkStatus();
  if (spec.points) return WithFieldPrefix(Check(*spec.points, limits), "points.");
  return FieldError(
      absl::StatusCode::kInvalidArgument, "MISSING_FIELD", "points",
      absl::StrCat("found none, need a picture, a lightmap or points for ", NameOf(spec)));
}

// Ids hold no blanks, so that the parts cannot run into each other.
std::string SpecKey(const ArtifactSpec& spec) {
  return absl::StrCat(NameOf(spec), " ", spec.light_id, " ", spec.receiver_id, " ",
                      spec.time_budget_ms, " ", spec.points ? HashOf(*spec.points).hex() : "", " ",
                      std::visit([](const auto& params) { return KeyOf(params); }, spec.params));
}

}  // namespace penumbra
