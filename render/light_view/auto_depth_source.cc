#include "render/light_view/auto_depth_source.h"

#include <utility>

#include "absl/strings/str_cat.h"

namespace penumbra {

DepthSource& AutoDepthSource::SourceFor(bool is_drawn) {
  if (!is_drawn) {
    uses_split_ = true;
    return split_;
  }
  if (!raster_) raster_.emplace(scene_, arena_);
  return *raster_;
}

absl::Status AutoDepthSource::Draw(std::span<const LightView> views, const std::stop_token& stop,
                                   const Take& take) {
  if (absl::Status status = CheckViews(views); !status.ok()) return status;
  for (size_t first = 0; first < views.size();) {
    if (stop.stop_requested()) return absl::CancelledError("stopped");
    const bool is_drawn = IsDrawn(views[first]);
    size_t end = first + 1;
    while (end < views.size() && IsDrawn(views[end]) == is_drawn) ++end;
    absl::Status status = SourceFor(is_drawn).Draw(
        views.subspan(first, end - first), stop,
        [&](size_t index, DepthMap map) { return take(first + index, std::move(map)); });
    if (!status.ok()) return status;
    first = end;
  }
  return absl::OkStatus();
}

std::string AutoDepthSource::drawn_by() const {
  const std::string raster(NameOf(DepthMethod::kRaster)), split = split_.drawn_by();
  if (!uses_split_) return raster_ ? raster : std::string(NameOf(DepthMethod::kAuto));
  return raster_ && !split.starts_with(raster) ? absl::StrCat(raster, " and ", split) : split;
}

}  // namespace penumbra
