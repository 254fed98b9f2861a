#include "render/light_view/auto_depth_source.h"

#include <utility>

#include "absl/strings/str_cat.h"

namespace penumbra {

DepthSource& AutoDepthSource::SourceFor(DepthMethod method) {
  if (method == DepthMethod::kRays) {
    if (!rays_) rays_.emplace(bvhs_.Of(scene_), arena_);
    return *rays_;
  }
  if (!raster_) raster_.emplace(scene_, arena_);
  return *raster_;
}

absl::Status AutoDepthSource::Draw(std::span<const LightView> views, const std::stop_token& stop,
                                   const Take& take) {
  if (absl::Status status = CheckViews(views); !status.ok()) return status;
  for (size_t first = 0; first < views.size();) {
    if (stop.stop_requested()) return absl::CancelledError("stopped");
    const DepthMethod method = MethodFor(views[first]);
    size_t end = first + 1;
    while (end < views.size() && MethodFor(views[end]) == method) ++end;
    absl::Status status = SourceFor(method).Draw(
        views.subspan(first, end - first), stop,
        [&](size_t index, DepthMap map) { return take(first + index, std::move(map)); });
    if (!status.ok()) return status;
    first = end;
  }
  return absl::OkStatus();
}

std::string AutoDepthSource::drawn_by() const {
  if (raster_ && rays_) return absl::StrCat(raster_->drawn_by(), " and ", rays_->drawn_by());
  if (raster_) return raster_->drawn_by();
  return rays_ ? rays_->drawn_by() : std::string(NameOf(DepthMethod::kAuto));
}

}  // namespace penumbra
