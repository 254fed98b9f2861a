#include "render/reference/light_integral.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "render/reference/adaptive_integral.h"

namespace penumbra {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kOuterTolerance = 1e-9;
constexpr double kInnerTolerance = 1e-12;

struct Surface {
  DVec3 point;
  DVec3 normal;
};

// ∫ g(x) dx over the part of [a, b] where the linear function with values h_a and h_b is positive.
template <typename Integrand>
double IntegrateWherePositive(const Integrand& g, double a, double b, double h_a, double h_b) {
  if (h_a <= 0 && h_b <= 0) return 0;
  const double crossing = a + (b - a) * (h_a / (h_a - h_b));
  if (h_a < 0) return AdaptiveIntegral(g, crossing, b, kInnerTolerance);
  if (h_b < 0) return AdaptiveIntegral(g, a, crossing, kInnerTolerance);
  return AdaptiveIntegral(g, a, b, kInnerTolerance);
}

// ∫ f(x) dx from the least to the greatest of `cuts`, each stretch between neighbours for itself.
template <typename Integrand>
double IntegrateInStretches(const Integrand& f, std::vector<double> cuts) {
  std::sort(cuts.begin(), cuts.end());
  double sum = 0;
  for (size_t i = 1; i < cuts.size(); ++i) {
    sum += AdaptiveIntegral(f, cuts[i - 1], cuts[i], kOuterTolerance);
  }
  return sum;
}

// cos θ cos θ' / r² at the light's point `x`, whose unit normal is `front`.
double Kernel(const Surface& surface, DVec3 x, DVec3 front, bool two_sided) {
  const DVec3 to_light = x - surface.point;
  const double r2 = glm::dot(to_light, to_light);
  const double emitted = -glm::dot(front, to_light);
  if (emitted <= 0 && !two_sided) return 0;
  return std::max(0.0, glm::dot(surface.normal, to_light)) * std::abs(emitted) / (r2 * r2);
}

// ∫ max(0, cos θ) dω over all directions within `half_angle` of `axis`, for a cap that fills less
// than a hemisphere. At angle a from the axis and azimuth φ, cos θ = cos a cos γ + sin a sin γ cos
// φ, with γ between axis and normal.
double CapIntegral(DVec3 normal, DVec3 axis, double half_angle) {
  const double cos_gamma = glm::dot(normal, axis);
  const double sin_gamma = glm::length(glm::cross(normal, axis));
  const auto ring = [&](double a) {
    const double middle = std::cos(a) * cos_gamma, swing = std::sin(a) * sin_gamma;
    double azimuth_end = kPi;
    if (middle + swing <= 0) return 0.0;
    if (middle - swing < 0) azimuth_end = std::acos(-middle / swing);
    const auto cosine = [&](double azimuth) { return middle + swing * std::cos(azimuth); };
    return 2 * std::sin(a) * AdaptiveIntegral(cosine, 0, azimuth_end, kInnerTolerance);
  };
  return AdaptiveIntegral(ring, 0, half_angle, kOuterTolerance);
}

double Integrate(const RectangleLight& light, const Surface& surface) {
  const DVec3 corner(light.corner), u(light.edge_u), v(light.edge_v);
  const DVec3 across = glm::cross(u, v);
  const double area = glm::length(across);
  const DVec3 front = across / area;
  const auto strip = [&](double s) {
    const DVec3 from = corner + s * u;
    const auto kernel = [&](double t) {
      return Kernel(surface, from + t * v, front, light.two_sided);
    };
    return IntegrateWherePositive(kernel, 0, 1, glm::dot(surface.normal, from - surface.point),
                                  glm::dot(surface.normal, from + v - surface.point));
  };
  // The horizon crosses the edges t = 0 and t = 1 at one s each.
  std::vector<double> cuts = {0, 1};
  for (const DVec3 start : {corner, corner + v}) {
    const double h_0 = glm::dot(surface.normal, start - surface.point);
    const double h_1 = h_0 + glm::dot(surface.normal, u);
    if (h_0 * h_1 < 0) cuts.push_back(h_0 / (h_0 - h_1));
  }
  return area * IntegrateInStretches(strip, std::move(cuts));
}

double Integrate(const DiskLight& light, const Surface& surface) {
  const DVec3 center(light.center), front = glm::normalize(DVec3(light.normal));
  const DVec3 away = std::abs(front.z) < 0.6 ? DVec3(0, 0, 1) : DVec3(1, 0, 0);
  const DVec3 u = glm::normalize(glm::cross(away, front)), v = glm::cross(front, u);
  const double radius = light.radius;
  const auto spoke = [&](double azimuth) {
    const DVec3 out = std::cos(azimuth) * u + std::sin(azimuth) * v;
    const auto kernel = [&](double r) {
      return r * Kernel(surface, center + r * out, front, light.two_sided);
    };
    const DVec3 to_center = center - surface.point;
    return IntegrateWherePositive(kernel, 0, radius, glm::dot(surface.normal, to_center),
                                  glm::dot(surface.normal, to_center + radius * out));
  };
  // On the rim, cos θ's numerator is A + B cos(azimuth − highest); the horizon crosses it twice.
  const double a = glm::dot(surface.normal, center - surface.point);
  const double b_u = glm::dot(surface.normal, u), b_v = glm::dot(surface.normal, v);
  const double b = radius * std::hypot(b_u, b_v), highest = std::atan2(b_v, b_u);
  if (a <= -b) return 0;
  if (a >= b) return IntegrateInStretches(spoke, {0, 2 * kPi});
  const double crossing = std::acos(-a / b);
  return IntegrateInStretches(
      spoke, {highest - crossing, highest, highest + crossing, highest + 2 * kPi - crossing});
}

double Integrate(const SphereLight& light, const Surface& surface) {
  const DVec3 to_center = DVec3(light.center) - surface.point;
  const double distance = glm::length(to_center);
  return CapIntegral(surface.normal, to_center / distance, std::asin(light.radius / distance));
}

double Integrate(const PointLight& light, const Surface& surface) {
  const DVec3 to_light = DVec3(light.position) - surface.point;
  const double r = glm::length(to_light);
  return std::max(0.0, glm::dot(surface.normal, to_light / r)) / (r * r);
}

// Between the cones the intensity falls as the square of a ramp that is linear in the cosine.
double Integrate(const SpotLight& light, const Surface& surface) {
  const DVec3 from_light = glm::normalize(surface.point - DVec3(light.position));
  const double cosine = glm::dot(from_light, glm::normalize(DVec3(light.direction)));
  const double full = std::cos(double{light.inner_angle}),
               none = std::cos(double{light.outer_angle});
  if (cosine <= none) return 0;
  const double ramp = cosine >= full ? 1 : (cosine - none) / (full - none);
  return ramp * ramp * Integrate(PointLight{.position = light.position}, surface);
}

// A disc of constant radiance that gives the light's irradiance to a surface that faces it.
double Integrate(const DistantLight& light, const Surface& surface) {
  const DVec3 axis = glm::normalize(DVec3(light.to_light));
  const double half_angle = 0.5 * light.angular_diameter;
  if (half_angle == 0) return std::max(0.0, glm::dot(surface.normal, axis));
  return CapIntegral(surface.normal, axis, half_angle) / CapIntegral(axis, axis, half_angle);
}

DVec3 Strength(const RectangleLight& light) { return DVec3(light.radiance); }
DVec3 Strength(const DiskLight& light) { return DVec3(light.radiance); }
DVec3 Strength(const SphereLight& light) { return DVec3(light.radiance); }
DVec3 Strength(const PointLight& light) { return DVec3(light.intensity); }
DVec3 Strength(const SpotLight& light) { return DVec3(light.intensity); }
DVec3 Strength(const DistantLight& light) { return DVec3(light.irradiance); }

}  // namespace

DVec3 IntegratedRadiance(const AreaLight& light, DVec3 point, DVec3 normal) {
  return std::visit(
      [&](const auto& shape) {
        return Strength(shape) * (Integrate(shape, {point, normal}) / kPi);
      },
      light.shape);
}

}  // namespace penumbra
