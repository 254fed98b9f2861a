// The triangles that can block light on one side of a receiver, laid out for the drawing kernels.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "render/math/aabb.h"
#include "render/math/vec.h"
#include "render/scene/light_sample.h"
#include "render/scene/receiver.h"
#include "render/scene/scene.h"
#include "tbb/task_arena.h"

namespace penumbra {

// What it takes to find an instance's outline from a light sample: the group's vertices are the
// mesh's, one for one.
struct Outline {
  std::shared_ptr<const Mesh> mesh;  // owns the edges
  const SilhouetteEdges* edges;
  DMat4 mesh_from_world{1.0};
  int32_t sign;  // makes every face count +1, whichever way it is seen: ±1
};

// What one instance contributes: ranges of the set's vertices and triangles.
struct OccluderGroup {
  uint32_t first_vertex = 0, vertex_count = 0;
  uint32_t first_triangle = 0, triangle_count = 0;
  Aabb bounds;                             // of the vertices
  float max_height = 0;                    // metres over the receiver's plane, on the set's side
  std::shared_ptr<const Instance> masked;  // has an alpha mask; null: opaque
  std::optional<Outline> outline;          // where silhouettes are asked for and can be had
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

// Which instances to take, by id, of those that cast; null: all.
using CasterFilter = std::function<bool(const std::string&)>;

// From how many triangles on a mesh gets an outline; all that has fewer is drawn face by face.
struct OutlineRule {
  uint32_t min_triangles = std::numeric_limits<uint32_t>::max();
};

// For each group the edges of its outline that any of some samples can see, where it is worth while
// to have found them; null: the group's own.
using SeenOutlines = std::vector<std::unique_ptr<const SilhouetteEdges>>;

// Shapes  G groups → G outlines
// Cost    as finding each outline once
SeenOutlines OutlinesSeenFrom(const OccluderSet& occluders, std::span<const LightSample> samples,
                              tbb::task_arena& arena);

// The parts of all casting instances that are more than `surface_offset` metres from the receiver's
// plane, on its front (side = +1) or its back (side = −1).
//
// Faces that look away from the light are marked as superfluous where the mesh is closed and the
// plane does not cut it: they cover just what those towards it do.
//
// Once `stop` is requested the set is left unfinished.
OccluderSet PrepareOccluders(const Scene& scene, const Parallelogram& patch, int side,
                             double surface_offset, const OutlineRule& outlines,
                             const CasterFilter& casters, const std::stop_token& stop = {});

}  // namespace penumbra
