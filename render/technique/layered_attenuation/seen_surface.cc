#include "render/technique/layered_attenuation/seen_surface.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "render/artifact/attenuation_ldi.h"
#include "render/artifact/plane_on_image.h"

namespace penumbra {
namespace {

// By `before`, `here` and `after`, of pixels in a row or column, where they are and see anything:
// from infinitely far nothing is at −∞.
float Slope(const float* before, float here, const float* after) {
  const bool has_before = before && std::isfinite(*before);
  const bool has_after = after && std::isfinite(*after);
  const float rise = has_before ? here - *before : 0.0f;
  const float next = has_after ? *after - here : rise;
  return !has_before || std::abs(next) < std::abs(rise) ? next : rise;
}

}  // namespace

NearnessMap::NearnessMap(DepthMap map) : view(map.view), nearness(std::move(map.depths)) {
  for (float& depth : nearness) depth = NearnessOf(view.from_infinity, depth);
}

Vec2 GradientAt(const NearnessMap& map, uint32_t x, uint32_t y) {
  const uint32_t width = map.view.width;
  const float* const here = map.Row(y) + x;
  return Vec2(Slope(x > 0 ? here - 1 : nullptr, *here, x + 1 < width ? here + 1 : nullptr),
              Slope(y > 0 ? here - width : nullptr, *here,
                    y + 1 < map.view.height ? here + width : nullptr));
}

ImagePlane WithoutCliffs(ImagePlane plane, float pixel_width, bool from_infinity) {
  const float width = from_infinity ? pixel_width : pixel_width * plane.nearness;
  const float limit = static_cast<float>(kMaxSteepness) * width;
  plane.gradient = glm::clamp(plane.gradient, Vec2(-limit), Vec2(limit));
  return plane;
}

}  // namespace penumbra
