#include "render/scene/area_light.h"

#include <numbers>

namespace penumbra {
namespace {

bool Equal(const RectangleLight& a, const RectangleLight& b) {
  return a.corner == b.corner && a.edge_u == b.edge_u && a.edge_v == b.edge_v &&
         a.radiance == b.radiance && a.two_sided == b.two_sided;
}
bool Equal(const DiskLight& a, const DiskLight& b) {
  return a.center == b.center && a.normal == b.normal && a.radius == b.radius &&
         a.radiance == b.radiance && a.two_sided == b.two_sided;
}
bool Equal(const SphereLight& a, const SphereLight& b) {
  return a.center == b.center && a.radius == b.radius && a.radiance == b.radiance;
}
bool Equal(const PointLight& a, const PointLight& b) {
  return a.position == b.position && a.intensity == b.intensity;
}
bool Equal(const SpotLight& a, const SpotLight& b) {
  return a.position == b.position && a.direction == b.direction && a.intensity == b.intensity &&
         a.inner_angle == b.inner_angle && a.outer_angle == b.outer_angle;
}
bool Equal(const DistantLight& a, const DistantLight& b) {
  return a.to_light == b.to_light && a.angular_diameter == b.angular_diameter &&
         a.irradiance == b.irradiance;
}

struct Area {
  float operator()(const RectangleLight& light) const {
    return glm::length(glm::cross(light.edge_u, light.edge_v));
  }
  float operator()(const DiskLight& light) const {
    return std::numbers::pi_v<float> * light.radius * light.radius;
  }
  float operator()(const SphereLight& light) const {
    return 4 * std::numbers::pi_v<float> * light.radius * light.radius;
  }
  float operator()(const PointLight&) const { return 0; }
  float operator()(const SpotLight&) const { return 0; }
  float operator()(const DistantLight&) const { return 0; }
};

}  // namespace

bool operator==(const AreaLight& a, const AreaLight& b) {
  if (a.id != b.id || a.shape.index() != b.shape.index()) return false;
  return std::visit(
      [&b](const auto& shape) {
        return Equal(shape, std::get<std::decay_t<decltype(shape)>>(b.shape));
      },
      a.shape);
}

float LightArea(const AreaLight& light) { return std::visit(Area{}, light.shape); }

}  // namespace penumbra
