#include "client/import/gltf/geometry.h"

#include <numeric>

#include "absl/strings/str_cat.h"
#include "client/import/gltf/accessor.h"
#include "client/import/source_file.h"
#include "render/scene/field_error.h"

namespace penumbra::gltf {
namespace {

constexpr char kDraco[] = "KHR_draco_mesh_compression";

std::string PathOf(int mesh, int primitive) {
  return absl::StrCat("meshes[", mesh, "].primitives[", primitive, "]");
}

bool IsTriangleMode(int mode) {
  return mode == TINYGLTF_MODE_TRIANGLES || mode == TINYGLTF_MODE_TRIANGLE_STRIP ||
         mode == TINYGLTF_MODE_TRIANGLE_FAN;
}

std::vector<Vec3> ToVec3s(const FloatArray& array) {
  std::vector<Vec3> out(array.size());
  for (size_t i = 0; i < out.size(); ++i) {
    const float* v = &array.values[i * array.components];
    out[i] = {v[0], v[1], v[2]};
  }
  return out;
}

// What makes two primitives the same mesh.
std::string KeyOf(const tinygltf::Primitive& primitive, const std::optional<TextureCoordinates>& uv,
                  const std::vector<double>& weights) {
  std::string key = absl::StrCat(primitive.mode, "|", primitive.indices, "|");
  for (const auto& [name, accessor] : primitive.attributes) {
    if (name == "POSITION" || name == "NORMAL") absl::StrAppend(&key, name, accessor, "|");
  }
  if (const auto* draco = FindExtension(primitive.extensions, kDraco)) {
    absl::StrAppend(&key, "draco", NumberOr(*draco, "bufferView", -1), "|");
  }
  if (uv) {
    const auto set = primitive.attributes.find(absl::StrCat("TEXCOORD_", uv->set));
    absl::StrAppend(&key, "uv", set == primitive.attributes.end() ? -1 : set->second, ",",
                    uv->offset.x, ",", uv->offset.y, ",", uv->rotation, ",", uv->scale.x, ",",
                    uv->scale.y, "|");
  }
  for (size_t i = 0; i < weights.size() && i < primitive.targets.size(); ++i) {
    const auto target = primitive.targets[i].find("POSITION");
    if (weights[i] == 0.0 || target == primitive.targets[i].end()) continue;
    absl::StrAppend(&key, "morph", target->second, "*", weights[i], "|");
  }
  return key;
}

}  // namespace

std::vector<uint32_t> ToTriangles(const std::vector<uint32_t>& corners, int mode) {
  const size_t n = corners.size();
  if (mode == TINYGLTF_MODE_TRIANGLES) return {corners.begin(), corners.end() - n % 3};
  std::vector<uint32_t> out;
  if (n < 3) return out;
  out.reserve(3 * (n - 2));
  for (size_t i = 0; i + 2 < n; ++i) {
    if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
      // Every other triangle of a strip runs the other way round.
      out.insert(out.end(), {corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]});
    } else {
      out.insert(out.end(), {corners[i + 1], corners[i + 2], corners[0]});
    }
  }
  return out;
}

absl::StatusOr<std::optional<DracoMesh>> Geometry::Unpack(const tinygltf::Primitive& primitive,
                                                          const std::string& path) {
  const auto* extension = FindExtension(primitive.extensions, kDraco);
  if (extension == nullptr || !extension->Has("bufferView")) return std::nullopt;
  std::map<std::string, int> ids;
  const tinygltf::Value& attributes = extension->Get("attributes");
  for (const std::string& name : attributes.Keys()) {
    if (name == "POSITION" || name == "NORMAL" || name.starts_with("TEXCOORD_")) {
      ids[name] = attributes.Get(name).GetNumberAsInt();
    }
  }
  auto packed = document_.ViewBytes(static_cast<int>(NumberOr(*extension, "bufferView", 0)));
  if (!packed.ok()) return packed.status();
  auto mesh =
      DecodeDraco(*packed, ids, absl::StrCat(path, ".extensions.", kDraco), document_.limits());
  if (!mesh.ok()) return mesh.status();
  return *std::move(mesh);
}

absl::StatusOr<std::optional<FloatArray>> Geometry::Attribute(const tinygltf::Primitive& primitive,
                                                              const DracoMesh* packed,
                                                              const std::string& name,
                                                              std::initializer_list<int> components,
                                                              const std::string& path) {
  const std::string attribute_path = absl::StrCat(path, ".attributes.", name);
  if (packed != nullptr) {
    const auto found = packed->attributes.find(name);
    if (found != packed->attributes.end()) {
      if (found->second.components != *components.begin()) {
        return Malformed("DRACO", attribute_path,
                         absl::StrCat("found ", found->second.components, " numbers each, need ",
                                      *components.begin()));
      }
      return found->second;
    }
  }
  const auto accessor = primitive.attributes.find(name);
  if (accessor == primitive.attributes.end()) return std::nullopt;
  auto values = ReadFloats(document_, accessor->second, components, attribute_path);
  if (!values.ok()) return values.status();
  return *std::move(values);
}

absl::StatusOr<std::vector<uint32_t>> Geometry::Triangles(const tinygltf::Primitive& primitive,
                                                          const DracoMesh* packed,
                                                          size_t vertex_count,
                                                          const std::string& path) {
  if (packed != nullptr) return packed->indices;
  std::vector<uint32_t> corners;
  if (primitive.indices >= 0) {
    auto indices = ReadIndices(document_, primitive.indices, path + ".indices");
    if (!indices.ok()) return indices.status();
    corners = *std::move(indices);
  } else {
    corners.resize(vertex_count);
    std::iota(corners.begin(), corners.end(), 0u);
  }
  if (primitive.mode == TINYGLTF_MODE_TRIANGLES && corners.size() % 3 != 0) {
    warnings_.Add(absl::StrCat(path, ": ", corners.size(), " corners, the last ",
                               corners.size() % 3, " make no triangle"));
  }
  return ToTriangles(corners, primitive.mode);
}

absl::Status Geometry::Morph(const tinygltf::Primitive& primitive,
                             const std::vector<double>& weights, const std::string& path,
                             MeshGeometry& geometry) {
  for (size_t t = 0; t < weights.size() && t < primitive.targets.size(); ++t) {
    const auto target = primitive.targets[t].find("POSITION");
    if (weights[t] == 0.0 || target == primitive.targets[t].end()) continue;
    const std::string target_path = absl::StrCat(path, ".targets[", t, "].POSITION");
    auto offsets = ReadFloats(document_, target->second, {3}, target_path);
    if (!offsets.ok()) return offsets.status();
    if (offsets->size() != geometry.positions.size()) {
      return Malformed("LENGTH", target_path,
                       absl::StrCat("found ", offsets->size(), ", need ", geometry.positions.size(),
                                    ", the number of positions"));
    }
    const std::vector<Vec3> moves = ToVec3s(*offsets);
    for (size_t i = 0; i < moves.size(); ++i) {
      geometry.positions[i] += static_cast<float>(weights[t]) * moves[i];
    }
    geometry.normals.clear();
  }
  return absl::OkStatus();
}

absl::Status Geometry::ReadUvs(const tinygltf::Primitive& primitive, const DracoMesh* packed,
                               const TextureCoordinates& uv, const std::string& path,
                               MeshGeometry& geometry) {
  const std::string name = absl::StrCat("TEXCOORD_", uv.set);
  auto uvs = Attribute(primitive, packed, name, {2}, path);
  if (!uvs.ok()) return uvs.status();
  if (!*uvs || (*uvs)->size() != geometry.positions.size()) {
    warnings_.Add(absl::StrCat(path, ".attributes.", name, ": not one a vertex, mask ignored"));
    return absl::OkStatus();
  }
  for (size_t i = 0; i < (*uvs)->size(); ++i) {
    geometry.uvs.push_back(uv.Apply({(*uvs)->values[2 * i], (*uvs)->values[2 * i + 1]}));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::optional<MeshGeometry>> Geometry::Read(
    int mesh, int primitive_index, const std::optional<TextureCoordinates>& uv,
    const std::vector<double>& weights) {
  const tinygltf::Primitive& primitive = document_.model().meshes[mesh].primitives[primitive_index];
  const std::string path = PathOf(mesh, primitive_index);
  if (!IsTriangleMode(primitive.mode)) {
    warnings_.Add(path + ": points or lines, which cast no shadow");
    return std::nullopt;
  }
  auto unpacked = Unpack(primitive, path);
  if (!unpacked.ok()) return unpacked.status();
  const DracoMesh* packed = *unpacked ? &**unpacked : nullptr;
  auto positions = Attribute(primitive, packed, "POSITION", {3}, path);
  if (!positions.ok()) return positions.status();
  if (!*positions) {
    warnings_.Add(path + ".attributes: no POSITION, nothing to place");
    return std::nullopt;
  }
  MeshGeometry geometry{.positions = ToVec3s(**positions)};
  auto triangles = Triangles(primitive, packed, geometry.positions.size(), path);
  if (!triangles.ok()) return triangles.status();
  geometry.indices = *std::move(triangles);

  auto normals = Attribute(primitive, packed, "NORMAL", {3}, path);
  if (!normals.ok()) return normals.status();
  if (*normals && (*normals)->size() == geometry.positions.size()) {
    geometry.normals = ToVec3s(**normals);
  }
  if (uv) {
    absl::Status status = ReadUvs(primitive, packed, *uv, path, geometry);
    if (!status.ok()) return status;
  }
  absl::Status status = Morph(primitive, weights, path, geometry);
  if (!status.ok()) return status;
  return geometry;
}

absl::StatusOr<SkinWeights> Geometry::ReadSkinWeights(int mesh, int primitive_index) {
  const tinygltf::Primitive& primitive = document_.model().meshes[mesh].primitives[primitive_index];
  const std::string path = PathOf(mesh, primitive_index);
  auto joints = Attribute(primitive, nullptr, "JOINTS_0", {4}, path);
  if (!joints.ok()) return joints.status();
  auto weights = Attribute(primitive, nullptr, "WEIGHTS_0", {4}, path);
  if (!weights.ok()) return weights.status();
  if (!*joints || !*weights) return SkinWeights{};
  return SkinWeights{
      .pairs = 4, .joints = std::move((*joints)->values), .weights = std::move((*weights)->values)};
}

absl::StatusOr<std::shared_ptr<const Mesh>> Geometry::Finish(MeshGeometry geometry,
                                                             const std::string& path) {
  vertices_read_ += std::max(geometry.positions.size(), geometry.indices.size() / 3);
  const uint64_t most = document_.limits().max_triangles_per_scene;
  if (vertices_read_ > most) {
    return FieldError(
        absl::StatusCode::kResourceExhausted, "TOO_LARGE", path,
        absl::StrCat("found ", vertices_read_, " vertices up to here, need <= ", most));
  }
  auto mesh = Mesh::Create(std::move(geometry), document_.limits());
  if (!mesh.ok()) return WithFieldPrefix(mesh.status(), path + ".");
  return mesh;
}

absl::StatusOr<std::shared_ptr<const Mesh>> Geometry::Get(
    int mesh, int primitive, const std::optional<TextureCoordinates>& uv,
    const std::vector<double>& weights) {
  const std::string key = KeyOf(document_.model().meshes[mesh].primitives[primitive], uv, weights);
  if (const auto known = known_.find(key); known != known_.end()) return known->second;
  auto geometry = Read(mesh, primitive, uv, weights);
  if (!geometry.ok()) return geometry.status();
  if (!*geometry) return nullptr;
  auto finished = Finish(**std::move(geometry), PathOf(mesh, primitive));
  if (!finished.ok()) return finished.status();
  return known_.emplace(key, *std::move(finished)).first->second;
}

}  // namespace penumbra::gltf
