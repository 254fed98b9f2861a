#include "client/display/render_options_check.h"

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

constexpr int kMaxPictureSide = 16'384;
constexpr int kMaxSamplesPerSide = 8;

absl::Status CheckRange(const char* field, int found, int max) {
  if (found >= 1 && found <= max) return absl::OkStatus();
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", field,
                    absl::StrCat("found ", found, ", need 1 to ", max));
}

}  // namespace

absl::Status CheckRenderOptions(const RenderOptions& options) {
  for (const auto& status :
       {CheckRange("width", options.width, kMaxPictureSide),
        CheckRange("height", options.height, kMaxPictureSide),
        CheckRange("samples_per_side", options.samples_per_side, kMaxSamplesPerSide),
        CheckRange("volume_look.passes", options.volume_look.passes, kMaxVolumePasses)}) {
    if (!status.ok()) return status;
  }
  if (!IsFinite(options.ambient)) {
    return FieldError(absl::StatusCode::kInvalidArgument, "NON_FINITE", "ambient",
                      "need finite numbers");
  }
  const float opacity = options.volume_look.opacity;
  if (!(opacity >= 0 && opacity <= 1)) {
    return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", "volume_look.opacity",
                      absl::StrCat("found ", opacity, ", need 0 to 1"));
  }
  return absl::OkStatus();
}

}  // namespace penumbra
