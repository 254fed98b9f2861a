#include "render/scene/receiver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "absl/strings/str_cat.h"
#include "render/math/aabb.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// Share of the extent by which a vertex may leave the plane: what modellers' files round away, and
// far below a texel.
constexpr double kPlanarTolerance = 1e-4;

absl::Status NotPlanar(const Instance& instance, std::string_view found) {
  return FieldError(
      absl::StatusCode::kFailedPrecondition, "NOT_PLANAR", "instance_id",
      absl::StrCat("found ", instance.id, ", which ", absl::string_view(found.data(), found.size()),
                   ", need an instance in one plane"));
}

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

struct PlaneFrame {
  DVec3 origin;
  DVec3 s, t;  // orthonormal, s × t is the front

  DVec2 Flatten(DVec3 p) const { return {glm::dot(p - origin, s), glm::dot(p - origin, t)}; }
  DVec3 Lift(DVec2 q) const { return origin + q.x * s + q.y * t; }
};

PlaneFrame FrameAcross(DVec3 normal, DVec3 origin) {
  const DVec3 axis = std::abs(normal.x) < 0.9 ? DVec3(1, 0, 0) : DVec3(0, 0, 1);
  const DVec3 s = glm::normalize(axis - glm::dot(axis, normal) * normal);
  return {origin, s, glm::cross(normal, s)};
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

}  // namespace

absl::StatusOr<Parallelogram> BoundingParallelogram(const Instance& instance) {
  const Mesh& mesh = *instance.mesh;
  std::vector<DVec3> corners;
  corners.reserve(mesh.indices().size());
  Aabb bounds;
  for (const uint32_t index : mesh.indices()) {
    const Vec3 p = TransformPoint(instance.world_from_mesh, mesh.positions()[index]);
    corners.emplace_back(p);
    bounds.Add(p);
  }
  DVec3 twice_area(0.0);
  double twice_size = 0;
  for (size_t t = 0; t < corners.size(); t += 3) {
    const DVec3 cross = glm::cross(corners[t + 1] - corners[t], corners[t + 2] - corners[t]);
    twice_area += cross;
    twice_size += glm::length(cross);
  }
  const double extent = glm::length(DVec3(bounds.extent()));
  if (!(glm::length(twice_area) > 1e-12 * extent * extent)) {
    return NotPlanar(instance, twice_size > 0 ? "has no front" : "covers no area");
  }
  const DVec3 normal = glm::normalize(twice_area);
  const PlaneFrame frame = FrameAcross(normal, corners[0]);
  const double tolerance = kPlanarTolerance * extent;
  std::vector<DVec2> flat;
  flat.reserve(corners.size());
  for (const DVec3& p : corners) {
    if (std::abs(glm::dot(p - frame.origin, normal)) > tolerance) {
      return NotPlanar(instance, "is not flat");
    }
    flat.push_back(frame.Flatten(p));
  }
  const std::vector<DVec2> hull = ConvexHull(std::move(flat), 0.01 * tolerance);
  if (hull.size() < 3) return NotPlanar(instance, "is too thin to have an area");
  const FlatBox box = SmallestParallelogram(hull, tolerance);
  return Parallelogram{.origin = Vec3(frame.Lift(box.corner)),
                       .edge_u = Vec3(box.u.x * frame.s + box.u.y * frame.t),
                       .edge_v = Vec3(box.v.x * frame.s + box.v.y * frame.t)};
}

}  // namespace penumbra
