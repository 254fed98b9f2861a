#include "render/technique/coherent_raytrace/reference_images.h"

#include <array>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"
#include "render/technique/coherent_raytrace/light_eye.h"

namespace penumbra {
namespace {

constexpr uint32_t kMaxPixels = 8192;

absl::Status Invalid(std::string_view reason, std::string_view field, std::string_view message) {
  return FieldError(absl::StatusCode::kInvalidArgument, reason, field, message);
}

absl::Status Check(const ReferenceImageSettings& settings) {
  if (settings.pixels < 1 || settings.pixels > kMaxPixels) {
    return Invalid("RANGE", "reference.pixels",
                   absl::StrCat("found ", settings.pixels, ", need 1 to ", kMaxPixels));
  }
  const GapBias& gap = settings.gap;
  for (const double bias : {gap.metres.value_or(0), gap.relative.value_or(0), gap.pixels}) {
    if (!(bias >= 0) || std::isinf(bias)) {
      return Invalid("RANGE", "reference.gap",
                     absl::StrCat("found ", bias, ", need a number >= 0"));
    }
  }
  for (size_t i = 0; i < settings.places.size(); ++i) {
    if (IsFinite(settings.places[i])) continue;
    return Invalid("NON_FINITE", absl::StrCat("reference.places[", i, "]"), "need finite numbers");
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<DepthPyramid>> DrawReferenceImages(
    const AreaLight& light, const Scene& scene, const ReferenceImageSettings& settings,
    DepthSource& source, const std::stop_token& stop) {
  if (absl::Status status = Check(settings); !status.ok()) return status;
  std::vector<DepthPyramid> images;
  for (const Vec3& place : settings.places.empty() ? LightVertices(light) : settings.places) {
    for (const auto& [view, covers_all] : ViewsFrom(light, scene, place, settings.pixels)) {
      const auto take = [&, covers = covers_all](size_t, const DepthMap& map) {
        images.emplace_back(map, settings.gap, covers);
        return absl::OkStatus();
      };
      if (absl::Status status = source.Draw(std::array{view}, stop, take); !status.ok()) {
        return status;
      }
    }
  }
  return images;
}

}  // namespace penumbra
