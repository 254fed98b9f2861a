#include "render/reference/light_quadrature.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>

namespace penumbra {
namespace {

constexpr double kPi = std::numbers::pi;

struct Axes {
  DVec3 u, v, w;
};

Axes AxesAbout(DVec3 direction) {
  const DVec3 w = glm::normalize(direction);
  const DVec3 u =
      glm::normalize(glm::cross(std::abs(w.y) < 0.7 ? DVec3(0, 1, 0) : DVec3(0, 0, 1), w));
  return {u, glm::cross(w, u), w};
}

QuadraturePoint At(DVec3 point, DVec3 facing, double measure, bool at_infinity = false) {
  return {{.point = Vec3(point), .at_infinity = at_infinity}, facing, measure};
}

// Calls body(a, b) with a and b at the middles of n intervals of [0, 1] each.
template <typename Body>
void ForGrid(uint32_t n, const Body& body) {
  for (uint32_t i = 0; i < n; ++i) {
    for (uint32_t j = 0; j < n; ++j) body((i + 0.5) / n, (j + 0.5) / n);
  }
}

struct Spread {
  uint32_t n;
  std::vector<QuadraturePoint> points{};

  void operator()(const RectangleLight& light) {
    const DVec3 u(light.edge_u), v(light.edge_v), across = glm::cross(u, v);
    const double area = glm::length(across);
    ForGrid(n, [&](double a, double b) {
      points.push_back(At(DVec3(light.corner) + a * u + b * v, across / area, area / (n * n)));
    });
  }
  void operator()(const DiskLight& light) {
    const Axes axes = AxesAbout(DVec3(light.normal));
    const double area = kPi * light.radius * light.radius;
    ForGrid(n, [&](double a, double b) {
      const double r = light.radius * std::sqrt(a), azimuth = 2 * kPi * b;
      points.push_back(
          At(DVec3(light.center) + r * std::cos(azimuth) * axes.u + r * std::sin(azimuth) * axes.v,
             axes.w, area / (n * n)));
    });
  }
  void operator()(const SphereLight& light) {
    const double area = 4 * kPi * light.radius * light.radius;
    ForGrid(n, [&](double a, double b) {
      const double z = 2 * a - 1, r = std::sqrt(1 - z * z), azimuth = 2 * kPi * b;
      const DVec3 out(r * std::cos(azimuth), z, r * std::sin(azimuth));
      points.push_back(At(DVec3(light.center) + double{light.radius} * out, out, area / (n * n)));
    });
  }
  void operator()(const DistantLight& light) {
    const Axes axes = AxesAbout(DVec3(light.to_light));
    const double lowest = std::cos(0.5 * double{light.angular_diameter});
    if (lowest == 1) {
      points.push_back(At(axes.w, DVec3(0.0), 1, true));
      return;
    }
    ForGrid(n, [&](double a, double b) {
      const double z = 1 - a * (1 - lowest), r = std::sqrt(1 - z * z), azimuth = 2 * kPi * b;
      const DVec3 d = r * std::cos(azimuth) * axes.u + r * std::sin(azimuth) * axes.v + z * axes.w;
      points.push_back(At(d, DVec3(0.0), 2 * kPi * (1 - lowest) / (n * n), true));
    });
  }
  void operator()(const PointLight& light) {
    points.push_back(At(DVec3(light.position), DVec3(0.0), 1));
  }
  void operator()(const SpotLight& light) {
    points.push_back(At(DVec3(light.position), DVec3(0.0), 1));
  }
};

// One sample of n as SampleLight places them.
struct Measured {
  const LightSample& sample;
  DVec3 target;
  double n;

  QuadraturePoint operator()(const RectangleLight& light) const {
    const DVec3 across = glm::cross(DVec3(light.edge_u), DVec3(light.edge_v));
    return {sample, glm::normalize(across), glm::length(across) / n};
  }
  QuadraturePoint operator()(const DiskLight& light) const {
    return {sample, glm::normalize(DVec3(light.normal)), kPi * light.radius * light.radius / n};
  }
  // The hemisphere is flattened onto the disc through the centre: a surface element at the angle φ
  // to the axis shrinks to cos φ of its area.
  QuadraturePoint operator()(const SphereLight& light) const {
    const DVec3 out = (DVec3(sample.point) - DVec3(light.center)) / double{light.radius};
    const DVec3 axis = target - DVec3(light.center);
    const double cos_phi = glm::dot(out, axis) / (glm::length(out) * glm::length(axis));
    return {sample, out,
            kPi * light.radius * light.radius / n / std::max(cos_phi, 0.5 / std::sqrt(n))};
  }
  QuadraturePoint operator()(const DistantLight& light) const {
    if (light.angular_diameter == 0) return {sample, DVec3(0.0), 1};
    const double sine = std::sin(0.5 * double{light.angular_diameter});
    const double cos_phi =
        glm::dot(DVec3(sample.point), DVec3(light.to_light)) / glm::length(DVec3(light.to_light));
    return {sample, DVec3(0.0), kPi * sine * sine / n / cos_phi};
  }
  template <typename Point>
  QuadraturePoint operator()(const Point&) const {
    return {sample, DVec3(0.0), 1};
  }
};

// Radiance times dω, so that both kinds of light come out alike.
struct Arriving {
  const QuadraturePoint& from;
  DVec3 d;  // from the surface to the light
  double FromSurface(bool two_sided) const {
    const double cosine = -glm::dot(from.facing, glm::normalize(d));
    const double turned = two_sided ? std::abs(cosine) : std::max(0.0, cosine);
    return from.measure * turned / glm::dot(d, d);
  }
  DVec3 operator()(const RectangleLight& l) const {
    return DVec3(l.radiance) * FromSurface(l.two_sided);
  }
  DVec3 operator()(const DiskLight& l) const {
    return DVec3(l.radiance) * FromSurface(l.two_sided);
  }
  DVec3 operator()(const SphereLight& l) const { return DVec3(l.radiance) * FromSurface(false); }
  DVec3 operator()(const PointLight& l) const { return DVec3(l.intensity) / glm::dot(d, d); }
  DVec3 operator()(const SpotLight& l) const {
    const double cosine = -glm::dot(glm::normalize(d), glm::normalize(DVec3(l.direction)));
    const double none = std::cos(double{l.outer_angle}), full = std::cos(double{l.inner_angle});
    const double ramp = std::clamp((cosine - none) / (full - none), 0.0, 1.0);
    return DVec3(l.intensity) * ramp * ramp / glm::dot(d, d);
  }
  DVec3 operator()(const DistantLight& l) const {
    const double sine = std::sin(0.5 * double{l.angular_diameter});
    if (sine == 0) return DVec3(l.irradiance);
    return DVec3(l.irradiance) * (from.measure / (kPi * sine * sine));
  }
};

}  // namespace

std::vector<QuadraturePoint> LightQuadrature(const AreaLight& light, uint32_t per_side) {
  Spread spread{per_side};
  std::visit(spread, light.shape);
  return std::move(spread.points);
}

std::vector<QuadraturePoint> MeasuredSamples(const AreaLight& light,
                                             std::span<const LightSample> samples, DVec3 target) {
  std::vector<QuadraturePoint> points;
  for (const LightSample& sample : samples) {
    const Measured measured{sample, target, static_cast<double>(samples.size())};
    points.push_back(std::visit(measured, light.shape));
  }
  return points;
}

DVec3 DirectRadiance(const AreaLight& light, std::span<const QuadraturePoint> points, DVec3 point,
                     DVec3 normal, std::span<const uint8_t> visible) {
  DVec3 sum(0.0);
  for (size_t i = 0; i < points.size(); ++i) {
    if (!visible.empty() && !visible[i]) continue;
    const LightSample& sample = points[i].sample;
    const DVec3 d = sample.at_infinity ? DVec3(sample.point) : DVec3(sample.point) - point;
    const double cosine = glm::dot(normal, glm::normalize(d));
    if (cosine > 0) sum += cosine * std::visit(Arriving{points[i], d}, light.shape);
  }
  return sum / kPi;
}

}  // namespace penumbra
