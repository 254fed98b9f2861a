#include "render/scene/unoccluded_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "render/math/form_factor.h"

namespace penumbra {
namespace {

constexpr double kPi = std::numbers::pi;

// Whether `point` is on a side of the emitting plane that is lit.
bool SeesEmittingSide(DVec3 on_plane, DVec3 front, bool two_sided, DVec3 point) {
  return two_sided || glm::dot(front, point - on_plane) > 0;
}

double Factor(const RectangleLight& light, DVec3 point, DVec3 normal) {
  const DVec3 corner(light.corner), u(light.edge_u), v(light.edge_v);
  if (!SeesEmittingSide(corner, glm::cross(u, v), light.two_sided, point)) return 0;
  const std::array<DVec3, 4> polygon = {corner, corner + u, corner + u + v, corner + v};
  return PolygonFormFactor(polygon, point, normal);
}

double Factor(const DiskLight& light, DVec3 point, DVec3 normal) {
  const DVec3 axis = glm::normalize(DVec3(light.normal));
  const DVec3 center(light.center);
  if (!SeesEmittingSide(center, axis, light.two_sided, point)) return 0;
  return DiskFormFactor(center, axis, light.radius, point, normal);
}

double Factor(const SphereLight& light, DVec3 point, DVec3 normal) {
  const DVec3 to_center = DVec3(light.center) - point;
  const double distance2 = glm::dot(to_center, to_center);
  const double radius2 = double{light.radius} * light.radius;
  if (distance2 <= radius2) return 1;  // inside, where every direction shines
  return CapFormFactor(glm::dot(normal, to_center) / std::sqrt(distance2), radius2 / distance2);
}

// Irradiance over π at `point` of unit intensity at `position`.
double PointFactor(DVec3 position, DVec3 point, DVec3 normal) {
  const DVec3 to_light = position - point;
  const double distance2 = glm::dot(to_light, to_light);
  if (distance2 == 0) return 0;
  return std::max(0.0, glm::dot(normal, to_light)) / (kPi * distance2 * std::sqrt(distance2));
}

double Factor(const PointLight& light, DVec3 point, DVec3 normal) {
  return PointFactor(light.position, point, normal);
}

double Factor(const SpotLight& light, DVec3 point, DVec3 normal) {
  const DVec3 from_light = point - DVec3(light.position);
  const double distance = glm::length(from_light);
  if (distance == 0) return 0;
  return SpotCone(light).Falloff(from_light / distance) *
         PointFactor(light.position, point, normal);
}

// Irradiance over π of a disc in the sky that gives unit irradiance head-on: cap form factor over
// sin² α.
double Factor(const DistantLight& light, DVec3 /*point*/, DVec3 normal) {
  const double cos_to_light = glm::dot(normal, glm::normalize(DVec3(light.to_light)));
  const double sin_alpha = std::sin(0.5 * double{light.angular_diameter});
  if (sin_alpha < 1e-6) return std::max(0.0, cos_to_light) / kPi;
  const double sin2_alpha = sin_alpha * sin_alpha;
  return CapFormFactor(cos_to_light, sin2_alpha) / (kPi * sin2_alpha);
}

Vec3 Emission(const RectangleLight& light) { return light.radiance; }
Vec3 Emission(const DiskLight& light) { return light.radiance; }
Vec3 Emission(const SphereLight& light) { return light.radiance; }
Vec3 Emission(const PointLight& light) { return light.intensity; }
Vec3 Emission(const SpotLight& light) { return light.intensity; }
Vec3 Emission(const DistantLight& light) { return light.irradiance; }

}  // namespace

SpotCone::SpotCone(const SpotLight& light)
    : axis(glm::normalize(DVec3(light.direction))),
      cos_outer(std::cos(double{light.outer_angle})),
      cos_inner(std::cos(double{light.inner_angle})) {}

double SpotCone::Falloff(DVec3 direction) const {
  const double above = glm::dot(axis, direction) - cos_outer;
  const double ramp = std::clamp(above / std::max(1e-12, cos_inner - cos_outer), 0.0, 1.0);
  return ramp * ramp;
}

Vec3 LightStrength(const AreaLight& light) {
  return std::visit([](const auto& shape) { return Emission(shape); }, light.shape);
}

double UnoccludedFactor(const AreaLight& light, DVec3 point, DVec3 normal) {
  return std::visit([&](const auto& shape) { return Factor(shape, point, normal); }, light.shape);
}

Vec3 UnoccludedRadiance(const AreaLight& light, Vec3 point, Vec3 normal) {
  return LightStrength(light) *
         static_cast<float>(UnoccludedFactor(light, DVec3(point), DVec3(normal)));
}

}  // namespace penumbra
