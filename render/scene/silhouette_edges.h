// The edges of a mesh at which its outline, seen from a point, can lie: those between a face turned
// towards the viewpoint and one turned away, and those of faces that have no neighbour there.
//
//   SilhouetteList list;
//   mesh.silhouette_edges().Find(viewpoint, list);
//
// Filling the shadow of a mesh needs these edges alone: where two faces of one facing meet, what
// one's edge adds to a running sum the other's takes away.
//
// Source  Herf 1997, §4.3.3 and §4.4.2; departs: an edge of more than two faces, or of two that run
//         along it the same way, counts as that many edges of one face each, so any mesh will do;
//         clusters are of edges, with a cone around the normals of their faces, and are
//         tested sixteen at a time
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/math/vec.h"

namespace penumbra {

// Edges found, as parallel arrays of which the first `count` entries hold.
//
// `weight`  what crossing the edge changes the number of surfaces in front by, on the side that it
//           leaves at its left when seen with the faces' front: ±2 between two faces, ±1 where
//           there is one face
struct SilhouetteList {
  std::vector<uint32_t> from, to;  // vertices
  std::vector<int32_t> weight;
  size_t count = 0;

  void Clear() { count = 0; }
  void Reserve(size_t more);
};

// Edges of a cluster: a vector of the widest instruction set.
inline constexpr size_t kClusterEdges = 16;

// The planes of an edge's face, for each edge of a cluster; a viewpoint is in front where
// nx·x + ny·y + nz·z − offset·w > 0. Zeros, past the last edge, have nobody in front.
struct FacePlanes {
  float x[kClusterEdges], y[kClusterEdges], z[kClusterEdges], offset[kClusterEdges];
};

// Edges of one face, and edges between two of which the left one runs along them. Each cluster lies
// together in memory: it is looked at as a whole, and clusters in any order.
struct alignas(64) BorderCluster {
  uint32_t from[kClusterEdges], to[kClusterEdges];
  FacePlanes left;
};
struct alignas(64) EdgeCluster {
  uint32_t from[kClusterEdges], to[kClusterEdges];
  FacePlanes left, right;
};

// What bounds the faces of runs of edges: a ball around their corners and a cone around their
// normals. Parallel arrays; sixteen clusters have one parent in the next level.
struct ClusterLevel {
  std::vector<float> x, y, z, radius;
  std::vector<float> axis_x, axis_y, axis_z;
  std::vector<float> cos_spread, sin_spread;  // cos ≤ 0: any direction
  size_t count = 0;                           // clusters; the arrays go on with padding
};

// Viewpoints around one, in homogeneous coordinates as it: all within `radius`.
struct ViewBall {
  DVec4 center{0.0};
  double radius = 0;

  // Around all of some viewpoints, which are positions or else directions.
  static ViewBall Around(std::span<const DVec4> viewpoints);
};

class SilhouetteEdges {
 public:
  // Shapes  V positions, 3T indices < V
  // Cost    O(T log T) time, 64 bytes a triangle of a closed mesh
  SilhouetteEdges(std::span<const Vec3> positions, std::span<const uint32_t> indices);

  // Appends the outline's edges as seen from `viewpoint`: (x, y, z, 1) a position, (x, y, z, 0) a
  // direction towards it. Which of two equal faces seen edge-on counts as turned towards it is
  // decided in single precision, and once for each face, so the edges always close up.
  //
  // Cost  O(T): every edge is looked at
  void Find(DVec4 viewpoint, SilhouetteList& list) const;
  // The same for each of several viewpoints, list by list: quicker for neighbours, as clusters and
  // edges that none of them has on its outline are left out together.
  //
  // Shapes  n viewpoints, positions or else directions, and n lists
  void FindEach(std::span<const DVec4> viewpoints, std::span<SilhouetteList> lists) const;

  // Only the edges that can lie on the outline seen from somewhere in `ball`: Find gives the same
  // for viewpoints in it, and looks at fewer edges.
  SilhouetteEdges SeenFrom(const ViewBall& ball) const;

  // Numbers the vertices that edges run between from 0, and returns which they were of the mesh's
  // `vertex_count`.
  std::vector<uint32_t> RenumberVertices(size_t vertex_count);

  // Pairs of faces, and edges of one face.
  size_t shared_edge_count() const { return shared_count_; }
  size_t border_edge_count() const { return border_count_; }
  size_t bytes() const;

 private:
  struct Builder;

  SilhouetteEdges() = default;

  // What rounding may do to a viewpoint's height over a face.
  double Slack(DVec4 viewpoint) const;

  DVec3 center_{0.0};  // the planes and clusters are of the mesh moved by −center_
  double extent_ = 0;  // from center_ to the furthest corner of the bounds
  size_t shared_count_ = 0, border_count_ = 0;
  std::vector<EdgeCluster> shared_;
  std::vector<BorderCluster> border_;
  // Bounds of the shared edges' clusters, of which the first level has one each.
  std::vector<ClusterLevel> levels_;
};

}  // namespace penumbra
