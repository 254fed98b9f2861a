#include "render/light_view/clip_triangle.h"

#include <algorithm>
#include <utility>

namespace penumbra {
namespace {

bool IsBefore(DVec3 a, DVec3 b) {
  if (a.x != b.x) return a.x < b.x;
  if (a.y != b.y) return a.y < b.y;
  return a.z < b.z;
}

// Where an edge crosses a plane; the same from either end.
ClipCorner Crossing(const ClipCorner& a, const ClipCorner& b, double above_a, double above_b) {
  if (IsBefore(b.place, a.place)) return Crossing(b, a, above_b, above_a);
  const double t = above_a / (above_a - above_b);
  return {.place = a.place + t * (b.place - a.place)};
}

// Keeps what is on or above a plane of which `above` tells a corner's height.
template <typename Above>
void Keep(ClippedTriangle& polygon, const Above& above) {
  const ClippedTriangle old = polygon;
  polygon.count = 0;
  const auto add = [&](const ClipCorner& corner) {
    // Rounding may cross a polygon with no width more often than a plane can.
    if (polygon.count < polygon.corners.size()) polygon.corners[polygon.count++] = corner;
  };
  for (size_t i = 0; i < old.count; ++i) {
    const ClipCorner &a = old.corners[i], &b = old.corners[(i + 1) % old.count];
    const double above_a = above(a.place), above_b = above(b.place);
    if (above_a >= 0) add(a);
    if ((above_a >= 0) != (above_b >= 0)) add(Crossing(a, b, above_a, above_b));
  }
}

}  // namespace

ClippedTriangle ClipTriangle(const std::array<ClipCorner, 3>& corners, double near, double reach) {
  ClippedTriangle polygon{.count = corners.size()};
  std::ranges::copy(corners, polygon.corners.begin());
  if (std::ranges::all_of(corners, &ClipCorner::is_placed)) return polygon;
  Keep(polygon, [&](DVec3 p) { return p.z - near; });
  for (int axis = 0; axis < 2; ++axis) {
    Keep(polygon, [&](DVec3 p) { return reach * p.z - p[axis]; });
    Keep(polygon, [&](DVec3 p) { return reach * p.z + p[axis]; });
  }
  for (size_t i = 0; i < polygon.count; ++i) {
    ClipCorner& corner = polygon.corners[i];
    if (corner.is_placed) continue;
    // Rounding must not lead out again.
    corner.at = Vec2(glm::clamp(DVec2(corner.place) / corner.place.z, -reach, reach));
    corner.is_placed = true;
  }
  return polygon;
}

}  // namespace penumbra
