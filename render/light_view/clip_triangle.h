// What of a triangle can be drawn: beyond the near plane, and not too far off the image.
//
//   const ClippedTriangle polygon = ClipTriangle(corners, near, reach);
//   for (size_t i = 2; i < polygon.count; ++i) …  // corners 0, i − 1 and i
#pragma once

#include <array>
#include <cstddef>

#include "render/math/vec.h"

namespace penumbra {

// A corner in homogeneous pixels: it is seen at xy / w, and w is its depth, or 1 from infinitely
// far.
struct ClipCorner {
  DVec3 place{0.0};
  // Where it is drawn: `place` rounded, unless it was placed otherwise before.
  Vec2 at{0.0f};
  bool is_placed = false;
};

// A polygon that is convex.
struct ClippedTriangle {
  // Each of five planes adds a corner at most.
  std::array<ClipCorner, 8> corners;
  size_t count = 0;  // fewer than 3: nothing is left
};

// Of the triangle what has w ≥ `near` and x and y within ±`reach`; all corners get their `at`.
// Triangles that share an edge get the same corners where it is cut, whichever comes first.
//
// Source  Sutherland and Hodgman 1974; departs: in homogeneous pixels
ClippedTriangle ClipTriangle(const std::array<ClipCorner, 3>& corners, double near, double reach);

}  // namespace penumbra
