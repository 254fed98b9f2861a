// The solids that the sample scene is put together from. Every mesh has normals; what is a solid is
// closed. Coordinates lie on a grid of 2⁻¹⁶ m, so that the last bit of a sine does not change a
// file.
#pragma once

#include <array>
#include <span>

#include "render/math/vec.h"
#include "render/scene/mesh.h"

namespace penumbra::sample {

// What is in `part` as well as in `whole`, in `whole`.
void Append(MeshGeometry& whole, const MeshGeometry& part);

// a, b, c, d run counter-clockwise.
MeshGeometry Quad(Vec3 a, Vec3 b, Vec3 c, Vec3 d);

MeshGeometry Box(Vec3 min, Vec3 max);

// A bar with square ends of the given sides; `side` is any direction not along it.
MeshGeometry Bar(Vec3 from, Vec3 to, Vec2 size_from, Vec2 size_to, Vec3 side = {1, 0, 0});

// `profile` (radius, height) turned about the y axis. Counter-clockwise seen with the axis to its
// left: it begins and ends on the axis and goes up on the outside. A point given twice makes an
// edge there.
MeshGeometry Turned(std::span<const Vec2> profile, int segments);

// As Turned, for a curve through `points` in `steps` steps from one to the next.
MeshGeometry TurnedSmooth(std::span<const Vec2> points, int steps, int segments);

// About the origin.
MeshGeometry Ball(float radius, int rings, int segments);

// A strip of `pieces` quads along an arc that starts at `root` in direction (cos azimuth, ·, sin
// azimuth) and bends down; uv (0, 1) and (1, 1) at the root.
struct Leaf {
  Vec3 root{0.0f};
  float azimuth = 0.0f;  // radians
  float rise = 1.2f;     // radians above the ground at the root
  float droop = 1.0f;    // radians less at the tip
  float length = 0.5f;   // metres
  float width = 0.2f;    // metres
};
MeshGeometry LeafCard(const Leaf& leaf, int pieces);

}  // namespace penumbra::sample
