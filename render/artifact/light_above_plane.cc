#include "render/artifact/light_above_plane.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <variant>

namespace penumbra {
namespace {

// Below this part of the steeper of two slopes the other changes the share by less than an eighth
// of it, and dividing by it would cost more.
constexpr double kFlat = 1e-5;

// ∫ clamp(x, 0, 1) dx from −∞.
double ClampIntegral(double x) {
  if (x <= 0) return 0;
  return x < 1 ? 0.5 * x * x : x - 0.5;
}

// ∫ √(radius² − y²) dy from 0 to y ≤ radius, times 2.
double HalfChords(double radius, double y) {
  const double ratio = std::clamp(y / radius, -1.0, 1.0);
  return radius * radius * (ratio * std::sqrt(1 - ratio * ratio) + std::asin(ratio));
}

struct Above {
  DVec3 point, normal;

  double HeightOf(DVec3 p) const { return glm::dot(p - point, normal); }
  double HeightOf(Vec3 p) const { return HeightOf(DVec3(p)); }
  double Rise(Vec3 along) const { return glm::dot(DVec3(along), normal); }
  bool IsBehind(Vec3 on_light, DVec3 front) const {
    return glm::dot(point - DVec3(on_light), front) <= 0;
  }

  double operator()(const RectangleLight& light) const {
    const DVec3 front = glm::cross(DVec3(light.edge_u), DVec3(light.edge_v));
    if (!light.two_sided && IsBehind(light.corner, front)) return 0;
    return SquareAbove(HeightOf(light.corner), Rise(light.edge_u), Rise(light.edge_v));
  }
  double operator()(const DiskLight& light) const {
    const DVec3 axis = glm::normalize(DVec3(light.normal));
    if (!light.two_sided && IsBehind(light.center, axis)) return 0;
    const double slope = glm::length(glm::cross(axis, normal));
    const double height = HeightOf(light.center), reach = slope * double{light.radius};
    if (std::abs(height) >= reach) return height > 0 ? 1 : 0;
    return DiscAbove(height / reach);
  }
  // In the image plane of an eye at the point that looks at the sphere's centre, the sphere is a
  // disc of radius tan α and the plane a line at tan β below its centre.
  double operator()(const SphereLight& light) const {
    const double distance = glm::distance(DVec3(light.center), point);
    const double radius{light.radius};
    if (distance <= radius) return 1;
    const double height = HeightOf(light.center);
    if (std::abs(height) >= radius) return height > 0 ? 1 : 0;
    const double tan_beta = height / std::sqrt(distance * distance - height * height);
    const double tan_alpha = radius / std::sqrt(distance * distance - radius * radius);
    return DiscAbove(tan_beta / tan_alpha);
  }
  double operator()(const PointLight& light) const { return HeightOf(light.position) > 0 ? 1 : 0; }
  double operator()(const SpotLight& light) const { return HeightOf(light.position) > 0 ? 1 : 0; }
  double operator()(const DistantLight& light) const {
    const double sin_height = glm::dot(glm::normalize(DVec3(light.to_light)), normal);
    return SkyDiscAbove(std::sin(0.5 * double{light.angular_diameter}), sin_height);
  }
};

}  // namespace

double SquareAbove(double a, double b, double c) {
  if (std::abs(b) < std::abs(c)) std::swap(b, c);
  if (b == 0) return a > 0 ? 1 : 0;
  if (b < 0) {
    a += b;  // seen from the other side: s becomes 1 − s
    b = -b;
  }
  // At t a length of clamp((a + b + c·t) / b, 0, 1) is above.
  const double first = (a + b) / b, last = (a + b + c) / b, change = c / b;
  if (std::abs(change) < kFlat) return std::clamp(0.5 * (first + last), 0.0, 1.0);
  return std::clamp((ClampIntegral(last) - ClampIntegral(first)) / change, 0.0, 1.0);
}

double DiscAbove(double d) {
  const double x = std::clamp(d, -1.0, 1.0);
  return 0.5 + (x * std::sqrt(1 - x * x) + std::asin(x)) / std::numbers::pi;
}

// On the plane that faces the axis the disc has the radius ρ = `sin_radius`, and the plane's
// horizon is half an ellipse with the half axes 1 and h = `sin_height`. What is beyond it is
//
//   ∫ √(ρ² − y²) − h √(1 − y²) dy over |y| < √((ρ² − h²) / (1 − h²)).
double SkyDiscAbove(double sin_radius, double sin_height) {
  const double h = std::abs(sin_height), rho = sin_radius;
  if (h >= rho) return sin_height > 0 ? 1 : 0;
  const double y = std::sqrt((rho * rho - h * h) / (1 - h * h));
  const double beyond =
      (HalfChords(rho, y) - h * HalfChords(1, y)) / (std::numbers::pi * rho * rho);
  return sin_height > 0 ? 1 - beyond : beyond;
}

float LightAbovePlane(const AreaLight& light, Vec3 point, Vec3 normal) {
  return static_cast<float>(std::visit(Above{DVec3(point), DVec3(normal)}, light.shape));
}

}  // namespace penumbra
