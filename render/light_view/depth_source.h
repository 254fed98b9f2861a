// What makes depth maps.
//
//   source->Draw(views, stop, [&](size_t index, DepthMap map) { …; return absl::OkStatus(); });
#pragma once

#include <functional>
#include <span>
#include <stop_token>
#include <string>

#include "absl/status/status.h"
#include "render/artifact/depth_map.h"

namespace penumbra {

// The part of a view's near depth that its sources begin before it: what is at the near depth, but
// for rounding, is seen.
inline constexpr double kNearMargin = 0x1p-20;

// Draws the casting instances of a scene. Each pixel is that of the ray through its centre; alpha
// masks cut holes. The same views give the same bits for any number of threads, however they are
// spread over calls.
//
// Two sources agree to a few millionths of a depth, but where a ray passes within rounding of an
// edge, of a mask's texel, or of the near plane; and where a surface is seen nearly from its edge,
// to what a thousandth of a pixel makes of it.
class DepthSource {
 public:
  // Takes the depth map of views[index], in the order of the views, on the thread that called Draw.
  using Take = std::function<absl::Status(size_t index, DepthMap map)>;

  virtual ~DepthSource() = default;

  // Views that follow each other are best of one frame. Of a view that is empty() the map sees
  // nothing.
  //
  // Errors  kCancelled: stop requested (asked at least once per view);
  //         kResourceExhausted, VIEW_SIZE: a view has more than kMaxViewSide pixels a side;
  //         those of `take`
  virtual absl::Status Draw(std::span<const LightView> views, const std::stop_token& stop,
                            const Take& take) = 0;

  // By which ways views have been drawn: "raster", "rays", "gl", "raster and rays"; "auto" where
  // that is not decided before the first.
  virtual std::string drawn_by() const = 0;
};

// The map of a view that sees nothing.
DepthMap NothingSeen(const LightView& view);

// How many of the views, from the first, are drawn together: eight, but of large ones fewer, whose
// maps wait for one another.
size_t ViewsAtOnce(std::span<const LightView> views);

// Errors  kResourceExhausted, VIEW_SIZE, "views[3].width"
absl::Status CheckViews(std::span<const LightView> views);

}  // namespace penumbra
