#include "render/artifact/light_width.h"

#include <cmath>
#include <numbers>
#include <variant>

#include "render/math/basis.h"

namespace penumbra {
namespace {

struct Axes {
  const LightFrame& frame;

  std::array<DVec3, 3> operator()(const RectangleLight& light) const {
    return {frame.DirectionFromWorld(DVec3(light.edge_u)),
            frame.DirectionFromWorld(DVec3(light.edge_v)), DVec3(0.0)};
  }
  std::array<DVec3, 3> operator()(const DiskLight& light) const {
    const Basis basis = BasisAround(DVec3(light.normal));
    const double width = std::numbers::sqrt3 * light.radius;
    return {frame.DirectionFromWorld(width * basis.s), frame.DirectionFromWorld(width * basis.t),
            DVec3(0.0)};
  }
  std::array<DVec3, 3> operator()(const SphereLight& light) const {
    const double width = std::numbers::sqrt3 * light.radius;
    return {DVec3(width, 0, 0), DVec3(0, width, 0), DVec3(0, 0, width)};
  }
  std::array<DVec3, 3> operator()(const PointLight&) const { return {}; }
  std::array<DVec3, 3> operator()(const SpotLight&) const { return {}; }
  std::array<DVec3, 3> operator()(const DistantLight& light) const {
    const double width = std::numbers::sqrt3 * std::tan(0.5 * light.angular_diameter);
    return {DVec3(width, 0, 0), DVec3(0, width, 0), DVec3(0.0)};
  }
};

}  // namespace

LightWidth::LightWidth(const AreaLight& light, const LightView& view)
    : from_infinity_(view.from_infinity), axes_(std::visit(Axes{view.frame}, light.shape)) {}

double LightWidth::Along(DVec2 at, DVec2 direction) const {
  const bool has_direction = direction != DVec2(0.0);
  double square = 0;
  for (const DVec3& axis : axes_) {
    const DVec2 shift = from_infinity_ ? DVec2(axis) : at * axis.z - DVec2(axis);
    square += has_direction ? glm::dot(shift, direction) * glm::dot(shift, direction)
                            : 0.5 * glm::dot(shift, shift);
  }
  return std::sqrt(square);
}

}  // namespace penumbra
