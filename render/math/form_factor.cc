#include "render/math/form_factor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "render/math/basis.h"

namespace penumbra {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr size_t kMaxVertices = 128;

// A polygon with room for what a cut adds: one vertex, or, where all of it lies in the horizon to
// within rounding, up to one a side.
struct Fan {
  std::array<DVec3, 2 * kMaxVertices> vertices;
  size_t size = 0;

  void Add(DVec3 v) { vertices[size++] = v; }
};

// The part of `polygon` (relative to the point) with n · v ≥ 0.
Fan CutAtHorizon(std::span<const DVec3> polygon, DVec3 point, DVec3 normal) {
  Fan above;
  DVec3 from = polygon.back() - point;
  double from_height = glm::dot(normal, from);
  for (const DVec3& vertex : polygon) {
    const DVec3 to = vertex - point;
    const double to_height = glm::dot(normal, to);
    if ((from_height < 0) != (to_height < 0)) {
      above.Add(from + (to - from) * (from_height / (from_height - to_height)));
    }
    if (to_height >= 0) above.Add(to);
    from = to;
    from_height = to_height;
  }
  return above;
}

// n · Φ; the form factor where the horizon does not cut the disc.
double WholeDiskFormFactor(DVec3 center, DVec3 axis, double radius, DVec3 point, DVec3 normal) {
  const DVec3 to_center = center - point;
  const double along = glm::dot(to_center, axis);
  const DVec3 across = to_center - along * axis;
  const double z = std::abs(along);
  const double z2 = z * z;
  const double rho2 = glm::dot(across, across);
  const double r2 = radius * radius;
  const double sum = z2 + rho2 + r2;
  const double difference = z2 + rho2 - r2;
  const double root = std::hypot(difference, 2 * z * radius);
  if (root == 0) return 0;  // on the rim
  // ½ (1 − difference / root).
  const double axial =
      difference > 0 ? 2 * z2 * r2 / (root * (root + difference)) : 0.5 * (1 - difference / root);
  const DVec3 towards_plane = along < 0 ? -axis : axis;
  // z / 2ρ² (sum / root − 1), where root² = sum² − 4 ρ² r² too. Neither form loses digits on a
  // distant disc.
  const double radial_over_rho = 2 * z * r2 / (root * (sum + root));
  return axial * glm::dot(normal, towards_plane) + radial_over_rho * glm::dot(normal, across);
}

}  // namespace

double PolygonFormFactor(std::span<const DVec3> vertices, DVec3 point, DVec3 normal) {
  if (vertices.size() < 3 || vertices.size() > kMaxVertices) return 0;
  const Fan polygon = CutAtHorizon(vertices, point, normal);
  double sum = 0;
  for (size_t i = 0; i < polygon.size; ++i) {
    const DVec3& from = polygon.vertices[i];
    const DVec3& to = polygon.vertices[i + 1 == polygon.size ? 0 : i + 1];
    const DVec3 cross = glm::cross(from, to);
    const double length = glm::length(cross);
    if (length == 0) continue;  // the edge points at us and fills no angle
    const double beta = std::atan2(length, glm::dot(from, to));
    sum += beta * glm::dot(normal, cross) / length;
  }
  return std::min(1.0, std::abs(sum) / (2 * kPi));
}

double DiskFormFactor(DVec3 center, DVec3 axis, double radius, DVec3 point, DVec3 normal) {
  // |n × axis| is the sine of the tilt without the cancellation of 1 − cos².
  const double reach = radius * glm::length(glm::cross(normal, axis));
  const double height = glm::dot(normal, center - point);
  if (height <= -reach) return 0;
  if (height >= reach) {
    return std::clamp(WholeDiskFormFactor(center, axis, radius, point, normal), 0.0, 1.0);
  }
  constexpr int kSides = 96;
  const double step = 2 * kPi / kSides;
  const double same_area_radius = radius * std::sqrt(step / std::sin(step));
  const auto [s, t, n] = BasisAround(axis);
  std::array<DVec3, kSides> rim;
  for (int i = 0; i < kSides; ++i) {
    rim[i] = center + same_area_radius * (std::cos(i * step) * s + std::sin(i * step) * t);
  }
  return PolygonFormFactor(rim, point, normal);
}

double CapFormFactor(double cos_to_axis, double sin2_alpha) {
  // Nusselt: F is 1/π times the area of the cap's part above the horizon, dropped onto the base
  // disc. The whole rim drops to an ellipse of area π sin² α cos ω. A cap that the horizon cuts
  // leaves the part of that ellipse above the cut (first two terms) and what lies between the cut
  // and the base disc's own edge (third).
  const double sin_alpha = std::sqrt(sin2_alpha);
  if (cos_to_axis >= sin_alpha) return cos_to_axis * sin2_alpha;
  if (cos_to_axis <= -sin_alpha) return 0;
  const double cos_alpha = std::sqrt(1 - sin2_alpha);
  const double sin_omega = std::sqrt(std::max(1e-300, 1 - cos_to_axis * cos_to_axis));
  const double cut = std::sqrt(sin2_alpha - cos_to_axis * cos_to_axis);
  const double ellipse_angle =
      std::acos(std::clamp(-cos_to_axis * cos_alpha / (sin_omega * sin_alpha), -1.0, 1.0));
  const double factor =
      cos_to_axis * sin2_alpha * ellipse_angle - cos_alpha * cut + std::atan2(cut, cos_alpha);
  return std::clamp(factor / kPi, 0.0, 1.0);
}

}  // namespace penumbra
