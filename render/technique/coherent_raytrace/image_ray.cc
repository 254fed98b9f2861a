#include "render/technique/coherent_raytrace/image_ray.h"

#include <algorithm>
#include <cmath>

namespace penumbra {

ImageOrigin::ImageOrigin(const DepthPyramid& seen_in, DVec3 point)
    : image(&seen_in), pixels(seen_in.view().pixels_per_slope()) {
  const LightView& view = seen_in.view();
  q = view.frame.FromWorld(point);
  DVec2 at;
  if (view.from_infinity) {
    at = DVec2(q) + q.z * DVec2(view.eye);
  } else {
    q -= view.eye;
    at = DVec2(q) / q.z;
  }
  start = DVec3((at - view.window.min) * pixels, seen_in.nearness().Of(q.z));
}

ImageRay::ImageRay(const ImageOrigin& origin, DVec3 way) : origin_(&origin) {
  const LightView& view = origin.image->view();
  const DVec3 w = view.frame.DirectionFromWorld(way);
  if (view.from_infinity) {
    depth_ = 1, deepening_ = 0;
    step_ = DVec3((DVec2(w) + w.z * DVec2(view.eye)) * origin.pixels, -w.z);
  } else {
    depth_ = origin.q.z, deepening_ = w.z;
    step_ = DVec3((DVec2(w) * depth_ - DVec2(origin.q) * w.z) * origin.pixels, -w.z);
  }
}

double ImageRay::ParameterAt(double t) const {
  if (origin_->image->view().from_infinity) return t;
  if (std::isinf(t)) return deepening_ > 0 ? 1 / (deepening_ * depth_) : t;
  return t / ((depth_ + t * deepening_) * depth_);
}

double ImageRay::WayAt(double s) const {
  if (origin_->image->view().from_infinity) return s;
  return s * depth_ * depth_ / (1 - s * depth_ * deepening_);
}

WayInterval ImageRay::ParametersOf(WayInterval t) const {
  const LightView& view = origin_->image->view();
  if (!view.from_infinity) {
    constexpr WayInterval kNothing{0, 0};
    if (!(depth_ > 0)) return kNothing;
    if (deepening_ == 0 && depth_ < view.near) return kNothing;
    if (deepening_ < 0) t.to = std::min(t.to, (view.near - depth_) / deepening_);
    if (deepening_ > 0) t.from = std::max(t.from, (view.near - depth_) / deepening_);
    if (t.empty()) return kNothing;
  }
  return {ParameterAt(t.from), ParameterAt(t.to)};
}

WayInterval ImageRay::Clip(WayInterval s) const {
  const LightView& view = origin_->image->view();
  const DVec2 size(view.width, view.height);
  for (int axis = 0; axis < 2; ++axis) {
    const double start = origin_->start[axis];
    if (step_[axis] == 0) {
      if (!(start >= 0 && start < size[axis])) return {0, 0};
      continue;
    }
    const double per_pixel = 1 / step_[axis];
    const double a = -start * per_pixel, b = (size[axis] - start) * per_pixel;
    s.from = std::max(s.from, std::min(a, b));
    s.to = std::min(s.to, std::max(a, b));
  }
  // From infinitely far there is no end to the ray; beyond the nearest there is nothing.
  if (view.from_infinity && step_.z > 0) {
    const double nearest = origin_->image->nearness().Of(view.near);
    s.to = std::min(s.to, (nearest * (1 + 1e-9) - origin_->start.z) / step_.z);
  }
  return s;
}

}  // namespace penumbra
