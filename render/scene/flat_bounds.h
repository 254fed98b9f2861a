// Points of one plane: the plane's frame, and the smallest parallelogram around them.
//
//   auto bounds = BoundFlat(corners, normal);
//   if (!bounds) …   // too thin to have an area
#pragma once

#include <optional>
#include <span>

#include "render/math/vec.h"
#include "render/scene/receiver.h"

namespace penumbra {

// Coordinates in a plane: s and t are orthonormal, s × t is the plane's normal.
struct PlaneFrame {
  DVec3 origin, s, t;

  DVec2 Flatten(DVec3 p) const { return {glm::dot(p - origin, s), glm::dot(p - origin, t)}; }
  DVec3 Lift(DVec2 q) const { return origin + q.x * s + q.y * t; }
};

// The same normal, of unit length, always gives the same directions.
PlaneFrame FrameAcross(DVec3 normal, DVec3 origin);

struct FlatBounds {
  Parallelogram patch;     // its front is where `normal` points
  double deviation = 0.0;  // the largest distance of a point from the plane through the first one
};

// The smallest parallelogram around `points`, projected onto the plane through the first of them. A
// hull of four corners that are a parallelogram within 1e-4 of the extent is taken as it is, other
// hulls get their smallest rectangle.
//
// normal   of unit length
// Returns  nothing where the points are thinner than 1e-6 of their extent, or fewer than three
// Cost     O(n log n)
// Source   Freeman and Shapira 1975; Andrew 1979 for the hull
std::optional<FlatBounds> BoundFlat(std::span<const DVec3> points, DVec3 normal);

}  // namespace penumbra
