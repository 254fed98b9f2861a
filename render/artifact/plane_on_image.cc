#include "render/artifact/plane_on_image.h"

#include <algorithm>
#include <cmath>

namespace penumbra {
namespace {

double Cut(double slope, double limit) {
  return std::isnan(slope) ? limit : std::clamp(slope, -limit, limit);
}

}  // namespace

std::optional<PlaneOnImage> PlaneOnImage::Find(const LightView& view, DVec3 point, DVec3 normal) {
  const DVec3 q = view.frame.FromWorld(point);
  const double depth = view.from_infinity ? q.z : q.z - view.eye.z;
  if (!view.from_infinity && !(depth > 0)) return std::nullopt;
  const DVec3 at = view.ProjectInFrame(q);
  if (!(at.x >= 0 && at.y >= 0 && at.x <= view.width && at.y <= view.height)) return std::nullopt;
  const DVec3 n = view.frame.DirectionFromWorld(normal);
  const DVec2 pixel = 1.0 / view.pixels_per_slope();
  PlaneOnImage plane{
      .at = DVec2(at), .nearness = NearnessOf(view.from_infinity, depth), .gradient{}, .width{}};
  plane.width = std::max(pixel.x, pixel.y) * (view.from_infinity ? 1 : plane.nearness);
  const DVec3 ray = view.from_infinity ? DVec3(-DVec2(view.eye), 1) : q - view.eye;
  const double facing = glm::dot(n, ray);
  const double limit = kMaxSteepness * plane.width;
  plane.gradient = DVec2(Cut(pixel.x * n.x / facing, limit), Cut(pixel.y * n.y / facing, limit));
  return plane;
}

}  // namespace penumbra
