#include "render/reference/exact_ray.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "render/reference/ray_visibility.h"

namespace penumbra {
namespace {

struct Segment {
  DVec3 from;
  DVec3 to;
  DVec3 direction() const { return to - from; }
};

// Barycentric coordinates at corners 1 and 2.
struct Hit {
  double b1, b2;
};

// Where the line through `ray` meets the plane; nullopt where they are parallel. `t` runs from 0 at
// ray.from to 1 at ray.to.
struct PlaneCrossing {
  double t, b1, b2;
};
std::optional<PlaneCrossing> CrossPlane(const Segment& ray, const OccluderTriangle& triangle) {
  const DVec3 e1 = triangle.corners[1] - triangle.corners[0];
  const DVec3 e2 = triangle.corners[2] - triangle.corners[0];
  const DVec3 p = glm::cross(ray.direction(), e2);
  const double det = glm::dot(e1, p);
  if (det == 0) return std::nullopt;
  const DVec3 s = ray.from - triangle.corners[0];
  const DVec3 q = glm::cross(s, e1);
  return PlaneCrossing{.t = glm::dot(e2, q) / det,
                       .b1 = glm::dot(s, p) / det,
                       .b2 = glm::dot(ray.direction(), q) / det};
}

std::optional<Hit> Intersect(const Segment& ray, const OccluderTriangle& triangle) {
  const auto crossing = CrossPlane(ray, triangle);
  if (!crossing || crossing->t < 0 || crossing->t > 1) return std::nullopt;
  if (crossing->b1 < 0 || crossing->b2 < 0 || crossing->b1 + crossing->b2 > 1) return std::nullopt;
  return Hit{crossing->b1, crossing->b2};
}

double PointSegmentDistance(DVec3 p, const Segment& s) {
  const DVec3 d = s.direction();
  const double length2 = glm::dot(d, d);
  const double t = length2 > 0 ? std::clamp(glm::dot(p - s.from, d) / length2, 0.0, 1.0) : 0.0;
  return glm::distance(p, s.from + t * d);
}

// The least distance is between end points and segments, or, where both feet of the common
// perpendicular lie within, along that.
double SegmentDistance(const Segment& a, const Segment& b) {
  double least = std::min({PointSegmentDistance(a.from, b), PointSegmentDistance(a.to, b),
                           PointSegmentDistance(b.from, a), PointSegmentDistance(b.to, a)});
  const DVec3 da = a.direction(), db = b.direction(), between = a.from - b.from;
  const DVec3 across = glm::cross(da, db);
  const double across2 = glm::dot(across, across);
  if (across2 == 0) return least;
  const double ta = glm::dot(glm::cross(db, between), across) / across2;
  const double tb = glm::dot(glm::cross(da, between), across) / across2;
  if (ta < 0 || ta > 1 || tb < 0 || tb > 1) return least;
  return std::min(least, std::abs(glm::dot(between, across)) / std::sqrt(across2));
}

double EdgeDistance(const Segment& ray, const OccluderTriangle& triangle) {
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const Segment edge{triangle.corners[k], triangle.corners[(k + 1) % 3]};
    least = std::min(least, SegmentDistance(ray, edge));
  }
  return least;
}

DVec3 UnitNormal(const OccluderTriangle& triangle) {
  const DVec3 normal = glm::cross(triangle.corners[1] - triangle.corners[0],
                                  triangle.corners[2] - triangle.corners[0]);
  const double length = glm::length(normal);
  return length > 0 ? normal / length : DVec3(0.0);
}

double PlaneDistance(DVec3 p, const OccluderTriangle& triangle) {
  return std::abs(glm::dot(UnitNormal(triangle), p - triangle.corners[0]));
}

// From a segment that misses the triangle: to its edges, or from an end that ends over its inside.
double MissDistance(const Segment& ray, const OccluderTriangle& triangle) {
  double least = EdgeDistance(ray, triangle);
  const DVec3 normal = UnitNormal(triangle);
  if (normal == DVec3(0.0)) return least;
  for (const DVec3 end : {ray.from, ray.to}) {
    if (Intersect({end - least * normal, end + least * normal}, triangle)) {
      least = std::min(least, PlaneDistance(end, triangle));
    }
  }
  return least;
}

// What it takes to make a hit a miss.
double HitSlack(const Segment& ray, const OccluderTriangle& triangle) {
  return std::min({EdgeDistance(ray, triangle), PlaneDistance(ray.from, triangle),
                   PlaneDistance(ray.to, triangle)});
}

bool MaskBlocksAt(const OccluderTriangle& triangle, double b1, double b2) {
  return MaskBlocks(*triangle.masked,
                    (1 - b1 - b2) * triangle.uvs[0] + b1 * triangle.uvs[1] + b2 * triangle.uvs[2]);
}

// Whether displaced rays find the same opacity.
bool MaskIsCertain(const Segment& ray, const OccluderTriangle& triangle, const Hit& hit,
                   double tolerance) {
  const DVec3 d = glm::normalize(ray.direction());
  const DVec3 away = std::abs(d.x) < 0.6 ? DVec3(1, 0, 0) : DVec3(0, 1, 0);
  const DVec3 u = glm::normalize(glm::cross(d, away)), v = glm::cross(d, u);
  const bool blocks = MaskBlocksAt(triangle, hit.b1, hit.b2);
  for (int k = 0; k < 8; ++k) {
    const double angle = 2 * M_PI * k / 8;
    const DVec3 shift = tolerance * (std::cos(angle) * u + std::sin(angle) * v);
    const auto near_by = CrossPlane({ray.from + shift, ray.to + shift}, triangle);
    if (!near_by || MaskBlocksAt(triangle, near_by->b1, near_by->b2) != blocks) return false;
  }
  return true;
}

double BoundingRadius(const OccluderTriangle& triangle, DVec3 center) {
  return std::max({glm::distance(center, triangle.corners[0]),
                   glm::distance(center, triangle.corners[1]),
                   glm::distance(center, triangle.corners[2])});
}

DVec3 Center(const OccluderTriangle& triangle) {
  return (triangle.corners[0] + triangle.corners[1] + triangle.corners[2]) / 3.0;
}

ExactVerdict JudgeRay(const Segment& ray, std::span<const OccluderTriangle* const> triangles,
                      double tolerance) {
  double hit_slack = 0, miss_slack = std::numeric_limits<double>::infinity();
  bool blocked = false;
  for (const OccluderTriangle* triangle : triangles) {
    const DVec3 center = Center(*triangle);
    const double gap = PointSegmentDistance(center, ray) - BoundingRadius(*triangle, center);
    if (gap > std::min(miss_slack, 100 * tolerance)) {
      miss_slack = std::min(miss_slack, gap);
      continue;
    }
    const auto hit = Intersect(ray, *triangle);
    if (!hit) {
      miss_slack = std::min(miss_slack, MissDistance(ray, *triangle));
      continue;
    }
    const bool masked = triangle->masked != nullptr;
    const bool certain = !masked || MaskIsCertain(ray, *triangle, *hit, tolerance);
    if (masked && !MaskBlocksAt(*triangle, hit->b1, hit->b2)) {
      if (!certain) miss_slack = 0;
      continue;
    }
    blocked = true;
    if (certain) hit_slack = std::max(hit_slack, HitSlack(ray, *triangle));
  }
  return {.blocked = blocked, .slack = blocked ? hit_slack : miss_slack};
}

}  // namespace

ExactRays::ExactRays(const Scene& scene) : triangles_(OccluderTriangles(scene)) {
  for (const OccluderTriangle& triangle : triangles_) {
    for (const DVec3 corner : triangle.corners) {
      const DVec3 a = glm::abs(corner);
      largest_coordinate_ = std::max({largest_coordinate_, a.x, a.y, a.z});
    }
  }
}

// Those that touch the cone, from `origin`, that holds all rays.
std::vector<const OccluderTriangle*> ExactRays::TrianglesNear(DVec3 origin,
                                                              std::span<const LightSample> samples,
                                                              double margin) const {
  const auto direction = [&](const LightSample& sample) {
    return glm::normalize(DVec3(sample.point) - (sample.at_infinity ? DVec3(0.0) : origin));
  };
  DVec3 axis(0.0);
  for (const LightSample& sample : samples) axis += direction(sample);
  axis = glm::normalize(axis);
  double spread = 0;  // tangent of the cone's half-angle
  for (const LightSample& sample : samples) {
    const double along = glm::dot(axis, direction(sample));
    const double across = glm::length(glm::cross(axis, direction(sample)));
    spread = along > 0 ? std::max(spread, across / along) : std::numeric_limits<double>::infinity();
  }
  std::vector<const OccluderTriangle*> near_by;
  for (const OccluderTriangle& triangle : triangles_) {
    const DVec3 center = Center(triangle);
    const double radius = BoundingRadius(triangle, center);
    const double from_axis = glm::length(glm::cross(axis, center - origin));
    const double reach = spread * (glm::distance(center, origin) + radius);
    if (!(from_axis > radius + reach + margin)) near_by.push_back(&triangle);
  }
  return near_by;
}

std::vector<ExactVerdict> ExactRays::Trace(const Parallelogram& patch, DVec3 origin,
                                           std::span<const LightSample> samples,
                                           double surface_offset, double tolerance) const {
  const auto triangles = TrianglesNear(origin, samples, 100 * tolerance);
  // A ray to infinity ends behind everything.
  const double behind = 4 * (largest_coordinate_ + glm::length(origin));
  std::vector<ExactVerdict> verdicts;
  for (const LightSample& sample : samples) {
    const RayInterval interval = BlockingInterval(patch, sample, surface_offset);
    const DVec3 target(sample.point);
    const DVec3 direction = sample.at_infinity ? target : target - origin;
    const DVec3 end = sample.at_infinity ? origin + behind * glm::normalize(target)
                                         : origin + interval.far * direction;
    verdicts.push_back(
        interval.near < interval.far
            ? JudgeRay({origin + interval.near * direction, end}, triangles, tolerance)
            : ExactVerdict{.slack = std::numeric_limits<double>::infinity()});
  }
  return verdicts;
}

}  // namespace penumbra
