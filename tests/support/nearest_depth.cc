#include "tests/support/nearest_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace penumbra::testing {
namespace {

// Shares of a triangle, or of a texel, within which a ray is at the edge.
constexpr double kEdge = 1e-3;

// How a ray meets a triangle: where, and how near to an edge in barycentric terms.
struct Meeting {
  double t;
  double margin;
  DVec3 weights;
};

std::optional<Meeting> Meet(DVec3 origin, DVec3 direction, const OccluderTriangle& triangle) {
  const auto& [a, b, c] = triangle.corners;
  const DVec3 e1 = b - a, e2 = c - a, normal = glm::cross(e1, e2);
  const double steep = glm::dot(normal, direction);
  const double scale = glm::length(normal) * glm::length(direction);
  if (scale == 0 || std::abs(steep) < 1e-9 * scale) return std::nullopt;
  const double t = glm::dot(normal, a - origin) / steep;
  const DVec3 p = origin + t * direction - a;
  const double area2 = glm::dot(normal, normal);
  const double v = glm::dot(glm::cross(p, e2), normal) / area2;
  const double w = glm::dot(glm::cross(e1, p), normal) / area2;
  return Meeting{.t = t, .margin = std::min({v, w, 1 - v - w}), .weights = DVec3(1 - v - w, v, w)};
}

enum class Sight { kThere, kHole, kUnsure };

Sight SightOf(const OccluderTriangle& triangle, DVec3 weights) {
  if (!triangle.masked) return Sight::kThere;
  const DVec2 uv =
      weights.x * triangle.uvs[0] + weights.y * triangle.uvs[1] + weights.z * triangle.uvs[2];
  const AlphaMask& mask = *triangle.masked->alpha_mask;
  const DVec2 texel = uv * DVec2(mask.width(), mask.height());
  const DVec2 off = glm::abs(texel - glm::round(texel));
  if (std::min(off.x, off.y) < kEdge) return Sight::kUnsure;
  return MaskBlocks(*triangle.masked, uv) ? Sight::kThere : Sight::kHole;
}

}  // namespace

double NearestDepth(const LightView& view, uint32_t x, uint32_t y,
                    const std::vector<OccluderTriangle>& triangles) {
  const DVec2 pixel(x + 0.5, y + 0.5);
  const double step = view.far - view.near;  // so that numbers are of the scene's size
  const DVec3 from = view.PointAt(pixel, view.near);
  const DVec3 along = (view.PointAt(pixel, view.near + step) - from) / step;
  double nearest = std::numeric_limits<double>::infinity();
  for (const OccluderTriangle& triangle : triangles) {
    const auto meeting = Meet(from, along, triangle);
    if (!meeting || meeting->margin < -kEdge) continue;
    const double depth = view.near + meeting->t;
    if (depth > nearest) continue;
    if (std::abs(meeting->margin) <= kEdge) return NAN;
    if (!view.from_infinity && std::abs(meeting->t) < 1e-4 * view.near) return NAN;
    if (!view.from_infinity && meeting->t < 0) continue;
    const Sight sight = SightOf(triangle, meeting->weights);
    if (sight == Sight::kUnsure) return NAN;
    if (sight == Sight::kThere) nearest = depth;
  }
  return nearest;
}

bool AreSameDepth(double a, double b, double size) {
  if (std::isinf(a) || std::isinf(b)) return a == b;
  return std::abs(a - b) <= kDepthTolerance * (std::abs(a) + size);
}

size_t DifferingDepths(const DepthMap& a, const DepthMap& b) {
  const double size = a.view.from_infinity ? a.view.far - a.view.near : 0.0;
  size_t differing = 0;
  for (size_t p = 0; p < a.depths.size(); ++p) {
    differing += !AreSameDepth(a.depths[p], b.depths[p], size);
  }
  return differing;
}

DepthComparison CompareWithNearest(const DepthMap& map,
                                   const std::vector<OccluderTriangle>& triangles) {
  DepthComparison result;
  // Metres; from infinitely far depths are about the middle of the scene.
  const double size = map.view.from_infinity ? map.view.far - map.view.near : 0.0;
  for (uint32_t y = 0; y < map.view.height; ++y) {
    for (uint32_t x = 0; x < map.view.width; ++x) {
      const double expected = NearestDepth(map.view, x, y, triangles);
      if (std::isnan(expected)) continue;
      ++result.compared;
      const double found = map.At(x, y);
      if (std::isinf(expected)) {
        result.differing += found != expected;
        continue;
      }
      ++result.seen;
      const double off = std::abs(found - expected) / (std::abs(expected) + size);
      if (off <= kDepthTolerance) {
        result.largest = std::max(result.largest, off);
      } else {
        ++result.differing;
      }
    }
  }
  return result;
}

std::vector<Aabb> CasterBoxes(const Scene& scene) {
  std::vector<Aabb> boxes;
  for (const auto& [id, instance] : scene.instances()) {
    if (instance->casts) boxes.push_back(WorldBounds(*instance));
  }
  return boxes;
}

}  // namespace penumbra::testing
