#include "render/technique/shadow_volume/shadow_volume_options.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

absl::Status CheckRange(double value, double least, double most, std::string_view field) {
  if (value >= least && value <= most) return absl::OkStatus();
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", field,
                    absl::StrCat("found ", value, ", need ", least, " to ", most));
}

}  // namespace

absl::Status CheckShadowVolumeOptions(const ShadowVolumeOptions& options) {
  absl::Status status =
      CheckRange(options.resolution, kMinVolumeResolution, kMaxVolumeResolution, "resolution");
  status.Update(CheckRange(options.bias_px, 0, kMaxVolumeBias, "bias"));
  if (options.edges.thresholds) {
    const EdgeThresholds& thresholds = *options.edges.thresholds;
    status.Update(CheckRange(thresholds.low, 0, kMaxEdgeThreshold, "low_threshold"));
    status.Update(CheckRange(thresholds.high, 0, kMaxEdgeThreshold, "high_threshold"));
  }
  return status;
}

}  // namespace penumbra
