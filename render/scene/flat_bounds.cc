#include "render/scene/flat_bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace penumbra {
namespace {

// Share of the extent by which a hull's corners may miss a parallelogram's.
constexpr double kCornerTolerance = 1e-4;

double Cross(DVec2 a, DVec2 b) { return a.x * b.y - a.y * b.x; }

// Counter-clockwise from the lexicographically first point, without points on the hull's edges.
// Source  Andrew 1979, monotone chain
std::vector<DVec2> ConvexHull(std::vector<DVec2> points, double tolerance) {
  const auto before = [](DVec2 a, DVec2 b) { return a.x < b.x || (a.x == b.x && a.y < b.y); };
  std::sort(points.begin(), points.end(), before);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  std::vector<DVec2> hull;
  const auto extend = [&](DVec2 p, size_t keep) {
    while (hull.size() > keep + 1) {
      const DVec2 last = hull.back();
      const DVec2 edge = p - hull[hull.size() - 2];
      if (Cross(last - hull[hull.size() - 2], edge) > tolerance * glm::length(edge)) break;
      hull.pop_back();
    }
    hull.push_back(p);
  };
  for (const DVec2& p : points) extend(p, 0);
  const size_t lower = hull.size() - 1;
  for (size_t i = points.size() - 1; i-- > 0;) extend(points[i], lower);
  hull.pop_back();
  return hull;
}

struct FlatBox {
  DVec2 corner, u, v;
  double area = std::numeric_limits<double>::infinity();
};

// The smallest rectangle around the hull: one of its sides lies along one of the hull's.
// Source  Freeman and Shapira 1975
FlatBox SmallestRectangle(const std::vector<DVec2>& hull) {
  FlatBox best;
  for (size_t i = 0; i < hull.size(); ++i) {
    const DVec2 along = glm::normalize(hull[(i + 1) % hull.size()] - hull[i]);
    const DVec2 across(-along.y, along.x);
    DVec2 low(std::numeric_limits<double>::infinity()), high = -low;
    for (const DVec2& p : hull) {
      const DVec2 q(glm::dot(p, along), glm::dot(p, across));
      low = glm::min(low, q);
      high = glm::max(high, q);
    }
    const double area = (high.x - low.x) * (high.y - low.y);
    if (area < best.area * (1 - 1e-9)) {
      best = {low.x * along + low.y * across, (high.x - low.x) * along, (high.y - low.y) * across,
              area};
    }
  }
  return best;
}

FlatBox SmallestParallelogram(const std::vector<DVec2>& hull, double tolerance) {
  if (hull.size() == 4 && glm::length(hull[0] + hull[2] - hull[1] - hull[3]) <= tolerance) {
    return {hull[0], hull[1] - hull[0], hull[3] - hull[0], 0};
  }
  return SmallestRectangle(hull);
}

double ExtentOf(std::span<const DVec3> points) {
  DVec3 low(std::numeric_limits<double>::infinity()), high = -low;
  for (const DVec3& p : points) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  return glm::length(high - low);
}

}  // namespace

PlaneFrame FrameAcross(DVec3 normal, DVec3 origin) {
  const DVec3 axis = std::abs(normal.x) < 0.9 ? DVec3(1, 0, 0) : DVec3(0, 0, 1);
  const DVec3 s = glm::normalize(axis - glm::dot(axis, normal) * normal);
  return {origin, s, glm::cross(normal, s)};
}

std::optional<FlatBounds> BoundFlat(std::span<const DVec3> points, DVec3 normal) {
  if (points.size() < 3) return std::nullopt;
  const double tolerance = kCornerTolerance * ExtentOf(points);
  const PlaneFrame frame = FrameAcross(normal, points[0]);
  FlatBounds bounds;
  std::vector<DVec2> flat;
  flat.reserve(points.size());
  for (const DVec3& p : points) {
    bounds.deviation = std::max(bounds.deviation, std::abs(glm::dot(p - frame.origin, normal)));
    flat.push_back(frame.Flatten(p));
  }
  const std::vector<DVec2> hull = ConvexHull(std::move(flat), 0.01 * tolerance);
  if (hull.size() < 3) return std::nullopt;
  const FlatBox box = SmallestParallelogram(hull, tolerance);
  bounds.patch = {.origin = Vec3(frame.Lift(box.corner)),
                  .edge_u = Vec3(box.u.x * frame.s + box.u.y * frame.t),
                  .edge_v = Vec3(box.v.x * frame.s + box.v.y * frame.t)};
  return bounds;
}

}  // namespace penumbra
