#include "render/artifact/light_view.h"

#include <array>

namespace penumbra {

Window Intersection(const Window& a, const Window& b) {
  return {.min = glm::max(a.min, b.min), .max = glm::min(a.max, b.max)};
}

DVec3 LightView::ProjectInFrame(DVec3 q) const {
  const double depth = from_infinity ? q.z : q.z - eye.z;
  const DVec2 at = from_infinity ? DVec2(q) + q.z * DVec2(eye) : (DVec2(q) - DVec2(eye)) / depth;
  return DVec3((at - window.min) * pixels_per_slope(), depth);
}

DVec3 LightView::PointAt(DVec2 pixel, double depth) const {
  const DVec2 at = window.min + pixel / pixels_per_slope();
  const DVec3 q =
      from_infinity ? DVec3(at - depth * DVec2(eye), depth) : DVec3(at * depth, depth) + eye;
  return frame.ToWorld(q);
}

bool IsSameView(const LightView& a, const LightView& b) {
  const auto numbers = [](const LightView& v) {
    return std::array{v.frame.origin,
                      v.frame.axes.s,
                      v.frame.axes.t,
                      v.frame.axes.n,
                      v.eye,
                      DVec3(v.window.min, v.near),
                      DVec3(v.window.max, v.far)};
  };
  return a.from_infinity == b.from_infinity && a.width == b.width && a.height == b.height &&
         numbers(a) == numbers(b);
}

}  // namespace penumbra
