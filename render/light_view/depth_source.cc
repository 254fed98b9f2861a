#include "render/light_view/depth_source.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "render/light_view/view_fit.h"
#include "render/scene/field_error.h"

namespace penumbra {

DepthMap NothingSeen(const LightView& view) {
  DepthMap map{.view = view};
  map.depths.assign(size_t{view.width} * view.height, kNoDepth);
  return map;
}

size_t ViewsAtOnce(std::span<const LightView> views) {
  constexpr size_t kMostViews = 8, kMostPixels = size_t{1} << 24;
  size_t pixels = 0, count = 0;
  for (const LightView& view : views) {
    pixels += size_t{view.width} * view.height;
    if (count > 0 && (count == kMostViews || pixels > kMostPixels)) break;
    ++count;
  }
  return count;
}

absl::Status CheckViews(std::span<const LightView> views) {
  for (size_t i = 0; i < views.size(); ++i) {
    for (const auto& [name, side] :
         {std::pair{"width", views[i].width}, std::pair{"height", views[i].height}}) {
      if (side <= kMaxViewSide) continue;
      return FieldError(absl::StatusCode::kResourceExhausted, "VIEW_SIZE",
                        absl::StrCat("views[", i, "].", name),
                        absl::StrCat("found ", side, " pixels, need at most ", kMaxViewSide));
    }
  }
  return absl::OkStatus();
}

}  // namespace penumbra
