// A mesh's triangles in clusters of neighbours, so that those that cannot matter are left out
// without a look at each.
//
//   clusters.tree.Visit(may_meet, [&](uint32_t c) { for (t = clusters.first_triangle[c]; …) … });
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/math/aabb.h"
#include "render/math/box_tree.h"
#include "render/math/vec.h"

namespace penumbra {

// C clusters of up to kClusterTriangles triangles, in the order of `tree`.
struct TriangleClusters {
  std::vector<uint32_t> first_vertex;    // C + 1, into `vertices`
  std::vector<uint32_t> first_triangle;  // C + 1
  std::vector<uint32_t> vertices;        // of the mesh; each once in every cluster that has it
  std::vector<uint16_t> corners;         // three a triangle: which of its cluster's vertices
  std::vector<Aabb> bounds;              // C, mesh space
  BoxTree tree;                          // over `bounds`; empty ones there are none

  size_t size() const { return bounds.size(); }
  size_t bytes() const;
};

// So few that a cluster is small beside its mesh, and so many that testing its box costs a
// hundredth of drawing it.
inline constexpr uint32_t kClusterTriangles = 128;

// Shapes  V positions, 3T indices < V → about T / 96 clusters
// Cost    O(T log T) time, 15 bytes a triangle
// Source  Herf 1997, §4.4.1; departs: the hierarchy goes on below the objects
TriangleClusters ClusterTriangles(std::span<const Vec3> positions,
                                  std::span<const uint32_t> indices);

}  // namespace penumbra
