#include "render/technique/artifact_spec.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "render/scene/field_error.h"

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

}  // namespace

absl::Status CheckTimeBudget(const ArtifactSpec& spec) {
  if (std::isfinite(spec.time_budget_ms) && spec.time_budget_ms >= 0) return absl::OkStatus();
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", "time_budget_ms",
                    absl::StrCat("found ", spec.time_budget_ms, ", need a number >= 0"));
}

// Ids hold no blanks, so that the parts cannot run into each other.
std::string SpecKey(const ArtifactSpec& spec) {
  const std::string_view name = InfoOf(spec.params).name;
  return absl::StrCat(absl::string_view(name.data(), name.size()), " ", spec.light_id, " ",
                      spec.receiver_id, " ", spec.time_budget_ms, " ",
                      std::visit([](const auto& params) { return KeyOf(params); }, spec.params));
}

}  // namespace penumbra
