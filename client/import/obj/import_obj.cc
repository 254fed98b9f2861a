#include "client/import/obj/import_obj.h"

#include <array>
#include <exception>
#include <map>
#include <sstream>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client/import/emitter.h"
#include "client/import/id_table.h"
#include "client/import/obj/obj_check.h"
#include "client/import/obj/obj_materials.h"
#include "client/import/source_file.h"
#include "client/import/warnings.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace obj {
namespace {

struct Parsed {
  tinyobj::attrib_t attributes;
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> materials;
};

absl::StatusOr<Parsed> Parse(std::string_view text, const std::filesystem::path& folder,
                             const SceneLimits& limits, Warnings& warnings) {
  absl::Status status = CheckObj(text, limits);
  if (!status.ok()) return status;
  Parsed parsed;
  LibraryReader libraries(folder, warnings);
  std::string warning, error;
  try {
    std::istringstream stream{std::string(text)};
    if (!tinyobj::LoadObj(&parsed.attributes, &parsed.shapes, &parsed.materials, &warning, &error,
                          &stream, &libraries, /*triangulate=*/true)) {
      return Malformed("OBJ", "obj", absl::StrCat("found ", Quoted(error), ", need an OBJ file"));
    }
  } catch (const std::exception& exception) {
    return Malformed("OBJ", "obj",
                     absl::StrCat("found ", Quoted(exception.what()), ", need an OBJ file"));
  }
  for (const absl::string_view line : absl::StrSplit(warning, '\n', absl::SkipWhitespace())) {
    warnings.Add(std::string(line));
  }
  return parsed;
}

// Collects the corners of some faces into a mesh, each different corner once.
class MeshBuilder {
 public:
  MeshBuilder(const tinyobj::attrib_t& attributes, bool with_uvs)
      : attributes_(attributes), with_uvs_(with_uvs) {}

  absl::Status Add(const tinyobj::index_t& corner, const std::string& path) {
    const auto in_range = [](int index, size_t numbers, size_t each) {
      return index >= 0 && static_cast<size_t>(index) < numbers / each;
    };
    if (!in_range(corner.vertex_index, attributes_.vertices.size(), 3)) {
      return Malformed("INDEX_RANGE", path,
                       absl::StrCat("found vertex ", corner.vertex_index + 1, ", need 1 to ",
                                    attributes_.vertices.size() / 3));
    }
    const bool has_normal = in_range(corner.normal_index, attributes_.normals.size(), 3);
    const bool has_uv = in_range(corner.texcoord_index, attributes_.texcoords.size(), 2);
    all_have_normals_ = all_have_normals_ && has_normal;
    const std::array<int, 3> key = {corner.vertex_index, has_normal ? corner.normal_index : -1,
                                    with_uvs_ && has_uv ? corner.texcoord_index : -1};
    const auto [known, is_new] =
        known_.try_emplace(key, static_cast<uint32_t>(geometry_.positions.size()));
    geometry_.indices.push_back(known->second);
    if (is_new) AddVertex(key);
    return absl::OkStatus();
  }

  MeshGeometry Take() {
    if (!all_have_normals_) geometry_.normals.clear();
    return std::move(geometry_);
  }

 private:
  void AddVertex(const std::array<int, 3>& key) {
    const auto triple = [](const std::vector<tinyobj::real_t>& from, int i) {
      return Vec3(from[3 * i], from[3 * i + 1], from[3 * i + 2]);
    };
    geometry_.positions.push_back(triple(attributes_.vertices, key[0]));
    geometry_.normals.push_back(key[1] < 0 ? Vec3(0.0f) : triple(attributes_.normals, key[1]));
    if (!with_uvs_) return;
    const std::vector<tinyobj::real_t>& uvs = attributes_.texcoords;
    // OBJ's v runs up, a mask's rows run down.
    geometry_.uvs.push_back(key[2] < 0 ? Vec2(0.0f)
                                       : Vec2(uvs[2 * key[2]], 1.0f - uvs[2 * key[2] + 1]));
  }

  const tinyobj::attrib_t& attributes_;
  const bool with_uvs_;
  bool all_have_normals_ = true;
  absl::flat_hash_map<std::array<int, 3>, uint32_t> known_;
  MeshGeometry geometry_;
};

class SceneReader {
 public:
  SceneReader(const Parsed& parsed, const SceneLimits& limits, Warnings& warnings)
      : parsed_(parsed), limits_(limits), warnings_(warnings) {}

  absl::StatusOr<ImportedScene> Read(const std::filesystem::path& path);

 private:
  absl::Status ReadShape(const tinyobj::shape_t& shape, const std::string& name);
  absl::Status AddInstance(MeshGeometry geometry, const Material& material,
                           const std::string& name);

  const Parsed& parsed_;
  const SceneLimits& limits_;
  Warnings& warnings_;
  std::vector<Material> materials_;
  Material plain_;
  IdTable instance_ids_, light_ids_;
  ImportedScene scene_;
};

absl::Status SceneReader::ReadShape(const tinyobj::shape_t& shape, const std::string& name) {
  if (!shape.lines.indices.empty() || !shape.points.indices.empty()) {
    warnings_.Add(absl::StrCat(name, ": points or lines, which cast no shadow"));
  }
  std::map<int, MeshBuilder> builders;  // by material
  for (size_t face = 0; 3 * face + 2 < shape.mesh.indices.size(); ++face) {
    int material = face < shape.mesh.material_ids.size() ? shape.mesh.material_ids[face] : -1;
    if (material >= static_cast<int>(materials_.size())) material = -1;
    const bool with_uvs = material >= 0 && materials_[material].mask;
    MeshBuilder& builder =
        builders.try_emplace(material, parsed_.attributes, with_uvs).first->second;
    for (size_t k = 0; k < 3; ++k) {
      absl::Status status = builder.Add(shape.mesh.indices[3 * face + k],
                                        absl::StrCat(Quoted(name), ".triangles[", face, "]"));
      if (!status.ok()) return status;
    }
  }
  for (auto& [index, builder] : builders) {
    const Material& material = index < 0 ? plain_ : materials_[index];
    const std::string suffix = builders.size() == 1 ? ""
                               : index < 0          ? ".plain"
                                                    : "." + parsed_.materials[index].name;
    absl::Status status = AddInstance(builder.Take(), material, name + suffix);
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status SceneReader::AddInstance(MeshGeometry geometry, const Material& material,
                                      const std::string& name) {
  if (scene_.instances.size() >= limits_.max_instances) {
    return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_INSTANCES", Quoted(name),
                      absl::StrCat("found more instances, need <= ", limits_.max_instances));
  }
  auto mesh = Mesh::Create(std::move(geometry), limits_);
  if (!mesh.ok()) return WithFieldPrefix(mesh.status(), Quoted(name) + ".");
  Instance instance{.id = instance_ids_.Add(name, "object"),
                    .mesh = *std::move(mesh),
                    .casts = material.casts,
                    .color = material.color,
                    .alpha_mask = material.mask};
  if (material.emission != Vec3(0.0f)) {
    const auto shape = EmitterShape(instance, material.emission, /*two_sided=*/false);
    if (shape && scene_.lights.size() < limits_.max_lights) {
      // The light must not stand in its own way, and outshines what falls on it.
      instance.casts = false;
      instance.receives = false;
      scene_.lights.push_back({.id = light_ids_.Add(instance.id), .shape = *shape});
    } else {
      warnings_.Add(absl::StrCat(instance.id,
                                 ": glows, but is no flat parallelogram and no sphere: no light"));
    }
  }
  scene_.instances.push_back(std::move(instance));
  return absl::OkStatus();
}

absl::StatusOr<ImportedScene> SceneReader::Read(const std::filesystem::path& path) {
  for (const tinyobj::material_t& material : parsed_.materials) {
    materials_.push_back(ReadMaterial(material, path.parent_path(), limits_, warnings_));
  }
  for (const tinyobj::shape_t& shape : parsed_.shapes) {
    absl::Status status = ReadShape(shape, shape.name.empty() ? path.stem().string() : shape.name);
    if (!status.ok()) return status;
  }
  if (scene_.instances.empty()) warnings_.Add("no faces, nothing casts a shadow");
  scene_.warnings = warnings_.lines();
  return std::move(scene_);
}

}  // namespace
}  // namespace obj

absl::StatusOr<ImportedScene> ImportObj(const std::filesystem::path& path,
                                        const SceneLimits& limits) {
  absl::StatusOr<std::vector<std::byte>> file = ReadFile(path);
  if (!file.ok()) return file.status();
  Warnings warnings;
  absl::StatusOr<obj::Parsed> parsed =
      obj::Parse(AsText(*file), path.parent_path(), limits, warnings);
  if (!parsed.ok()) return parsed.status();
  return obj::SceneReader(*parsed, limits, warnings).Read(path);
}

}  // namespace penumbra
