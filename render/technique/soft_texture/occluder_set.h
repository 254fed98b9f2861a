// The triangles that can block light on one side of a receiver, laid out for the drawing kernels.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "render/math/aabb.h"
#include "render/math/vec.h"
#include "render/scene/receiver.h"
#include "render/scene/scene.h"

namespace penumbra {

// What one instance contributes: ranges of the set's vertices and triangles.
struct OccluderGroup {
  uint32_t first_vertex = 0, vertex_count = 0;
  uint32_t first_triangle = 0, triangle_count = 0;
  Aabb bounds;                             // of the vertices
  float max_height = 0;                    // metres over the receiver's plane, on the set's side
  std::shared_ptr<const Instance> masked;  // has an alpha mask; null: opaque
};

// V vertices and T triangles. Coordinates are metres from the receiver's origin in world
// directions, so that a surface in the receiver's plane keeps its full precision.
struct OccluderSet {
  std::vector<float> x, y, z;                       // V, padded for whole vectors
  std::vector<uint32_t> corner0, corner1, corner2;  // T, padded
  // +1 or −1: the sign of the projected area with which the triangle faces the light, where faces
  // that look away need not be drawn. 0: draw both.
  std::vector<float> facing;  // T, padded
  std::vector<Vec2> uv;       // V if any group is masked, otherwise empty
  std::vector<OccluderGroup> groups;
};

// The parts of all casting instances that are more than `surface_offset` metres from the receiver's
// plane, on its front (side = +1) or its back (side = −1).
//
// Faces that look away from the light are marked as superfluous where the mesh is closed: a ray
// from the light meets a face towards it first. What the plane cuts away lies behind that face, so
// this holds for cut meshes too, as long as their faces look outward.
OccluderSet PrepareOccluders(const Scene& scene, const Parallelogram& patch, int side,
                             double surface_offset);

}  // namespace penumbra
