// Polygons as receivers: whether one is right, and the patch around it.

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "render/math/aabb.h"
#include "render/scene/field_error.h"
#include "render/scene/flat_bounds.h"
#include "render/scene/receiver_place.h"

namespace penumbra {
namespace {

// Shares of the extent: by which a vertex may leave the plane, as for instances; by which an edge
// may miss another and still touches it; and, of its square, the least area.
constexpr double kPlanarTolerance = 1e-4;
constexpr double kTouchTolerance = 1e-9;
constexpr double kLeastArea = 1e-7;

absl::Status Bad(const char* reason, const std::string& field, const std::string& text) {
  return FieldError(absl::StatusCode::kInvalidArgument, reason, field, text);
}

std::string VertexPath(size_t i) { return absl::StrCat("vertices[", i, "]"); }

// Twice the area, along the normal.
// Source  Newell's method, after Sutherland, Sproull and Schumacker 1974
DVec3 TwiceArea(std::span<const DVec3> vertices) {
  DVec3 sum(0.0);
  for (size_t i = 1; i + 1 < vertices.size(); ++i) {
    sum += glm::cross(vertices[i] - vertices[0], vertices[i + 1] - vertices[0]);
  }
  return sum;
}

double ExtentOf(const PlanarPolygon& polygon) {
  Aabb box;
  for (const Vec3& v : polygon.vertices) box.Add(v);
  return glm::length(DVec3(box.extent()));
}

std::vector<DVec3> InDouble(const PlanarPolygon& polygon) {
  return {polygon.vertices.begin(), polygon.vertices.end()};
}

absl::Status CheckNumbers(const PlanarPolygon& polygon, const SceneLimits& limits) {
  const size_t count = polygon.vertices.size();
  if (count < 3) {
    return Bad("LENGTH", "vertices", absl::StrCat("found ", count, " vertices, need 3 or more"));
  }
  if (count > limits.max_polygon_vertices) {
    return FieldError(
        absl::StatusCode::kResourceExhausted, "QUOTA_POLYGON_VERTICES", "vertices",
        absl::StrCat("found ", count, " vertices, need at most ", limits.max_polygon_vertices));
  }
  for (size_t i = 0; i < count; ++i) {
    const Vec3 v = polygon.vertices[i];
    if (!IsFinite(v))
      return Bad("NON_FINITE", VertexPath(i), "found NaN or ∞, need finite numbers");
    const Vec3 size = glm::abs(v);
    if (std::max({size.x, size.y, size.z}) > limits.max_coordinate) {
      return Bad("OUT_OF_BOUNDS", VertexPath(i),
                 absl::StrCat("found (", v.x, ", ", v.y, ", ", v.z, "), need at most ",
                              limits.max_coordinate, " in size"));
    }
  }
  return absl::OkStatus();
}

// The distance of `p` from the line from a to b, positive on its left.
double SideOf(DVec2 a, DVec2 b, DVec2 p) {
  const DVec2 along = b - a, to = p - a;
  const double length = glm::length(along);
  return length > 0 ? (along.x * to.y - along.y * to.x) / length : glm::length(to);
}

bool IsNear(DVec2 p, DVec2 a, DVec2 b, double tolerance) {
  const DVec2 along = b - a;
  const double t = std::clamp(glm::dot(p - a, along) / glm::dot(along, along), 0.0, 1.0);
  return glm::length(p - (a + t * along)) <= tolerance;
}

// Whether the segments ab and cd, which share no end, meet.
bool Meet(DVec2 a, DVec2 b, DVec2 c, DVec2 d, double tolerance) {
  if (IsNear(a, c, d, tolerance) || IsNear(b, c, d, tolerance) || IsNear(c, a, b, tolerance) ||
      IsNear(d, a, b, tolerance)) {
    return true;
  }
  return (SideOf(a, b, c) > 0) != (SideOf(a, b, d) > 0) &&
         (SideOf(c, d, a) > 0) != (SideOf(c, d, b) > 0);
}

// The first two edges that meet elsewhere than in the corner that they share.
std::optional<std::pair<size_t, size_t>> FindCrossing(std::span<const DVec2> points,
                                                      double tolerance) {
  const size_t n = points.size();
  for (size_t i = 0; i < n; ++i) {
    const DVec2 a = points[i], b = points[(i + 1) % n], c = points[(i + 2) % n];
    // The next edge may only share the corner: it must not run back over this one.
    if (glm::length(b - a) <= tolerance || IsNear(c, a, b, tolerance) ||
        IsNear(a, b, c, tolerance)) {
      return std::pair{i, (i + 1) % n};
    }
    for (size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;
      if (Meet(a, b, points[j], points[(j + 1) % n], tolerance)) return std::pair{i, j};
    }
  }
  return std::nullopt;
}

}  // namespace

absl::Status CheckPolygon(const PlanarPolygon& polygon, const SceneLimits& limits) {
  if (const auto status = CheckNumbers(polygon, limits); !status.ok()) return status;
  const std::vector<DVec3> vertices = InDouble(polygon);
  const double extent = ExtentOf(polygon);
  const DVec3 twice_area = TwiceArea(vertices);
  if (!(glm::length(twice_area) > 2 * kLeastArea * extent * extent)) {
    return Bad("ZERO_AREA", "vertices",
               absl::StrCat("found ", 0.5 * glm::length(twice_area), " m² in ", extent,
                            " m, need an area"));
  }
  const DVec3 normal = glm::normalize(twice_area);
  const PlaneFrame frame = FrameAcross(normal, vertices[0]);
  std::vector<DVec2> flat;
  for (size_t i = 0; i < vertices.size(); ++i) {
    const double off = std::abs(glm::dot(vertices[i] - vertices[0], normal));
    if (off > kPlanarTolerance * extent) {
      return Bad("NOT_PLANAR", VertexPath(i),
                 absl::StrCat("found it ", off, " m off the plane, need at most ",
                              kPlanarTolerance * extent));
    }
    flat.push_back(frame.Flatten(vertices[i]));
  }
  if (const auto crossing = FindCrossing(flat, kTouchTolerance * extent)) {
    return Bad("SELF_INTERSECTING", VertexPath(crossing->second),
               absl::StrCat("found that the edge from it meets the edge from vertices[",
                            crossing->first, "], need a simple polygon"));
  }
  if (!BoundFlat(vertices, normal)) {
    return Bad("ZERO_AREA", "vertices", "found a polygon too thin to have an area, need one");
  }
  return absl::OkStatus();
}

PlacedPatch PlaceOnPolygon(const PlanarPolygon& polygon) {
  const std::vector<DVec3> vertices = InDouble(polygon);
  const auto bounds = BoundFlat(vertices, glm::normalize(TwiceArea(vertices)));
  if (!bounds) return {};
  auto region = std::make_shared<PlanarRegion>();
  std::vector<DVec2> outline;
  for (const DVec3& p : vertices) outline.push_back(UvOnPatch(bounds->patch, p));
  region->Add(outline);
  return {.patch = bounds->patch, .region = std::move(region), .deviation_m = bounds->deviation};
}

}  // namespace penumbra
