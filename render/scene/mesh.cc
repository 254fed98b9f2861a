#include "render/scene/mesh.h"

#include <cmath>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/blob.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

template <typename V>
absl::Status CheckVectors(const std::vector<V>& values, std::string_view name, float bound) {
  for (size_t i = 0; i < values.size(); ++i) {
    for (int c = 0; c < V::length(); ++c) {
      const float x = values[i][c];
      if (std::isfinite(x) && std::abs(x) <= bound) continue;
      const bool finite = std::isfinite(x);
      return FieldError(absl::StatusCode::kInvalidArgument, finite ? "OUT_OF_BOUNDS" : "NON_FINITE",
                        absl::StrCat(absl::string_view(name.data(), name.size()), "[", i, "]"),
                        finite ? absl::StrCat("found ", x, ", need at most ", bound, " in size")
                               : absl::StrCat("found ", x, ", need finite numbers"));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckCounts(const MeshGeometry& geometry, const SceneLimits& limits) {
  const size_t vertices = geometry.positions.size();
  if (vertices > limits.max_vertices_per_mesh) {
    return FieldError(
        absl::StatusCode::kResourceExhausted, "QUOTA_VERTICES", "positions",
        absl::StrCat("found ", vertices, " vertices, need at most ", limits.max_vertices_per_mesh));
  }
  if (geometry.indices.size() % 3 != 0) {
    return FieldError(absl::StatusCode::kInvalidArgument, "LENGTH", "indices",
                      absl::StrCat("found ", geometry.indices.size(), ", need a multiple of 3"));
  }
  if (geometry.indices.size() / 3 > limits.max_triangles_per_mesh) {
    return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_TRIANGLES", "indices",
                      absl::StrCat("found ", geometry.indices.size() / 3,
                                   " triangles, need at most ", limits.max_triangles_per_mesh));
  }
  for (const auto& [name, count] :
       {std::pair{"normals", geometry.normals.size()}, std::pair{"uvs", geometry.uvs.size()}}) {
    if (count != 0 && count != vertices) {
      return FieldError(absl::StatusCode::kInvalidArgument, "LENGTH", name,
                        absl::StrCat("found ", count, ", need none or one for each of the ",
                                     vertices, " vertices"));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckIndices(const MeshGeometry& geometry) {
  for (size_t i = 0; i < geometry.indices.size(); ++i) {
    if (geometry.indices[i] >= geometry.positions.size()) {
      return FieldError(absl::StatusCode::kInvalidArgument, "INDEX_RANGE",
                        absl::StrCat("indices[", i, "]"),
                        absl::StrCat("found ", geometry.indices[i], ", need less than the ",
                                     geometry.positions.size(), " vertices"));
    }
  }
  return absl::OkStatus();
}

// −0 + 0 is 0, and everything else is itself.
template <typename V>
void DropNegativeZeros(std::vector<V>& values) {
  for (V& value : values) value += V(0.0f);
}

size_t CountDegenerate(const MeshGeometry& geometry) {
  size_t count = 0;
  for (size_t t = 0; t < geometry.indices.size(); t += 3) {
    const DVec3 a(geometry.positions[geometry.indices[t]]);
    const DVec3 b(geometry.positions[geometry.indices[t + 1]]);
    const DVec3 c(geometry.positions[geometry.indices[t + 2]]);
    if (glm::cross(b - a, c - a) == DVec3(0.0)) ++count;
  }
  return count;
}

}  // namespace

absl::StatusOr<std::shared_ptr<const Mesh>> Mesh::Create(MeshGeometry geometry,
                                                         const SceneLimits& limits) {
  for (const absl::Status& status :
       {CheckCounts(geometry, limits), CheckIndices(geometry),
        CheckVectors(geometry.positions, "positions", limits.max_coordinate),
        CheckVectors(geometry.normals, "normals", limits.max_coordinate),
        CheckVectors(geometry.uvs, "uvs", limits.max_coordinate)}) {
    if (!status.ok()) return status;
  }
  DropNegativeZeros(geometry.positions);
  DropNegativeZeros(geometry.normals);
  DropNegativeZeros(geometry.uvs);

  std::shared_ptr<Mesh> mesh(new Mesh);
  mesh->id_ = Sha256(EncodeBlob(geometry));
  for (const Vec3& p : geometry.positions) mesh->bounds_.Add(p);
  mesh->degenerate_triangle_count_ = CountDegenerate(geometry);
  mesh->geometry_ = std::move(geometry);
  return mesh;
}

MeshClosure Mesh::closure() const {
  std::call_once(closure_once_, [this] { closure_ = FindClosure(positions(), indices()); });
  return closure_;
}

const SilhouetteEdges& Mesh::silhouette_edges() const {
  std::call_once(silhouette_once_, [this] {
    silhouette_edges_ = std::make_unique<const SilhouetteEdges>(positions(), indices());
  });
  return *silhouette_edges_;
}

const TriangleClusters& Mesh::triangle_clusters() const {
  std::call_once(clusters_once_, [this] {
    triangle_clusters_ =
        std::make_unique<const TriangleClusters>(ClusterTriangles(positions(), indices()));
  });
  return *triangle_clusters_;
}

const PlanarSurfaces& Mesh::planar_surfaces() const {
  std::call_once(surfaces_once_, [this] {
    planar_surfaces_ = std::make_unique<const PlanarSurfaces>(positions(), indices());
  });
  return *planar_surfaces_;
}

}  // namespace penumbra
