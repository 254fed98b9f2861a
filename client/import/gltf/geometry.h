// Primitives of a document as meshes.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/import/gltf/document.h"
#include "client/import/gltf/draco_mesh.h"
#include "client/import/gltf/materials.h"
#include "client/import/warnings.h"
#include "render/scene/mesh.h"

namespace penumbra::gltf {

// How much of each joint moves a vertex, four or eight pairs a vertex.
struct SkinWeights {
  int pairs = 0;
  std::vector<float> joints;  // V·pairs, indices into the skin's joints
  std::vector<float> weights;
};

class Geometry {
 public:
  Geometry(Document& document, Warnings& warnings) : document_(document), warnings_(warnings) {}

  // Primitive `primitive` of mesh `mesh`, with its uvs when `uv` is given, and morphed by
  // `weights`. Primitives made from the same accessors share one mesh. Null for points and lines,
  // with a warning.
  //
  // Errors  kInvalidArgument; kResourceExhausted; the path starts with "meshes[…].primitives[…]" or
  //         names what that refers to
  absl::StatusOr<std::shared_ptr<const Mesh>> Get(int mesh, int primitive,
                                                  const std::optional<TextureCoordinates>& uv,
                                                  const std::vector<double>& weights);

  // The same, not shared, for a caller that bends it; and the weights to bend it by.
  absl::StatusOr<std::optional<MeshGeometry>> Read(int mesh, int primitive,
                                                   const std::optional<TextureCoordinates>& uv,
                                                   const std::vector<double>& weights);
  absl::StatusOr<SkinWeights> ReadSkinWeights(int mesh, int primitive);

  // Takes `geometry` into account against what a whole scene may hold, and checks it.
  absl::StatusOr<std::shared_ptr<const Mesh>> Finish(MeshGeometry geometry,
                                                     const std::string& path);

 private:
  absl::StatusOr<std::optional<FloatArray>> Attribute(const tinygltf::Primitive& primitive,
                                                      const DracoMesh* packed,
                                                      const std::string& name,
                                                      std::initializer_list<int> components,
                                                      const std::string& path);
  absl::StatusOr<std::optional<DracoMesh>> Unpack(const tinygltf::Primitive& primitive,
                                                  const std::string& path);
  absl::StatusOr<std::vector<uint32_t>> Triangles(const tinygltf::Primitive& primitive,
                                                  const DracoMesh* packed, size_t vertex_count,
                                                  const std::string& path);
  absl::Status ReadUvs(const tinygltf::Primitive& primitive, const DracoMesh* packed,
                       const TextureCoordinates& uv, const std::string& path,
                       MeshGeometry& geometry);
  absl::Status Morph(const tinygltf::Primitive& primitive, const std::vector<double>& weights,
                     const std::string& path, MeshGeometry& geometry);

  Document& document_;
  Warnings& warnings_;
  uint64_t vertices_read_ = 0;
  std::map<std::string, std::shared_ptr<const Mesh>> known_;
};

// Corners of the triangles that a list, strip or fan of `corners` stands for.
// Source  glTF 2.0, §3.7.2.1
std::vector<uint32_t> ToTriangles(const std::vector<uint32_t>& corners, int mode);

}  // namespace penumbra::gltf
