// An immutable indexed triangle mesh, named by the SHA-256 of its bytes.
//
//   auto mesh = Mesh::Create({.positions = …, .indices = …});
//   if (!mesh.ok()) return mesh.status();
//   scene_delta.upsert_instances.push_back({.id = "table", .mesh = *mesh});
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "render/math/aabb.h"
#include "render/math/vec.h"
#include "render/scene/content_hash.h"
#include "render/scene/mesh_closure.h"
#include "render/scene/planar_surfaces.h"
#include "render/scene/scene_limits.h"
#include "render/scene/silhouette_edges.h"
#include "render/scene/triangle_clusters.h"

namespace penumbra {

// V vertices and T triangles. `normals` and `uvs` are empty or hold one entry a vertex.
struct MeshGeometry {
  std::vector<Vec3> positions;    // V, in metres, mesh space
  std::vector<uint32_t> indices;  // 3T, each < V; front faces run counter-clockwise
  std::vector<Vec3> normals;      // 0 or V; for display only, shadows do not use them
  std::vector<Vec2> uvs;          // 0 or V; for alpha masks
};

class Mesh {
 public:
  // Checks and keeps `geometry`, with −0 turned into 0 so that equal shapes have equal names.
  // A mesh of no triangles is allowed and casts nothing; so are triangles of no area.
  //
  // Errors  kInvalidArgument, reasons NON_FINITE, OUT_OF_BOUNDS, INDEX_RANGE, LENGTH;
  //         kResourceExhausted, reasons QUOTA_VERTICES, QUOTA_TRIANGLES.
  //         The field path is the member's name with its index, "positions[3]".
  static absl::StatusOr<std::shared_ptr<const Mesh>> Create(MeshGeometry geometry,
                                                            const SceneLimits& limits = {});

  const ContentHash& id() const { return id_; }
  std::span<const Vec3> positions() const { return geometry_.positions; }
  std::span<const uint32_t> indices() const { return geometry_.indices; }
  std::span<const Vec3> normals() const { return geometry_.normals; }
  std::span<const Vec2> uvs() const { return geometry_.uvs; }
  const MeshGeometry& geometry() const { return geometry_; }
  size_t vertex_count() const { return geometry_.positions.size(); }
  size_t triangle_count() const { return geometry_.indices.size() / 3; }
  const Aabb& bounds() const { return bounds_; }
  // Triangles that repeat a corner or have no area; they cast no shadow.
  size_t degenerate_triangle_count() const { return degenerate_triangle_count_; }

  // Found on first use, kept with the mesh; any thread may ask.
  MeshClosure closure() const;
  const SilhouetteEdges& silhouette_edges() const;
  const TriangleClusters& triangle_clusters() const;
  const PlanarSurfaces& planar_surfaces() const;

 private:
  Mesh() = default;

  MeshGeometry geometry_;
  ContentHash id_;
  Aabb bounds_;
  size_t degenerate_triangle_count_ = 0;
  mutable std::once_flag closure_once_;
  mutable MeshClosure closure_ = MeshClosure::kOpen;
  mutable std::once_flag silhouette_once_;
  mutable std::unique_ptr<const SilhouetteEdges> silhouette_edges_;
  mutable std::once_flag clusters_once_;
  mutable std::unique_ptr<const TriangleClusters> triangle_clusters_;
  mutable std::once_flag surfaces_once_;
  mutable std::unique_ptr<const PlanarSurfaces> planar_surfaces_;
};

}  // namespace penumbra
