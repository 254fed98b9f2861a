#include "client/import/import_scene.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <new>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "client/import/gltf/import_gltf.h"
#include "client/import/obj/import_obj.h"
#include "client/import/ply/import_ply.h"
#include "client/import/source_file.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

using Importer = absl::StatusOr<ImportedScene> (*)(const std::filesystem::path&,
                                                   const SceneLimits&);

// The first letter that is no blank, in the first bytes of the file; empty when there is none.
std::string Opening(const std::filesystem::path& path) {
  std::array<char, 64> bytes{};
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), bytes.size());
  std::string text(bytes.data(), static_cast<size_t>(file.gcount()));
  if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
  return std::string(absl::StripLeadingAsciiWhitespace(text));
}

// Null when neither the first bytes nor the extension are known.
Importer FindImporter(const std::filesystem::path& path) {
  const std::string opening = Opening(path);
  if (opening.starts_with("glTF") || opening.starts_with("{")) return ImportGltf;
  if (opening.starts_with("ply\n") || opening.starts_with("ply\r")) return ImportPly;
  const std::string extension = absl::AsciiStrToLower(path.extension().string());
  if (extension == ".gltf" || extension == ".glb") return ImportGltf;
  if (extension == ".obj") return ImportObj;
  if (extension == ".ply") return ImportPly;
  return nullptr;
}

}  // namespace

absl::StatusOr<ImportedScene> ImportScene(const std::filesystem::path& path,
                                          const SceneLimits& limits) {
  const std::string name = path.filename().string();
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return ReadFile(path).status();
  const Importer importer = FindImporter(path);
  if (importer == nullptr) {
    return Malformed("FORMAT", name, "found an unknown kind of file, need glTF, GLB, OBJ or PLY");
  }
  try {
    absl::StatusOr<ImportedScene> imported = importer(path, limits);
    if (imported.ok() || ErrorFieldPath(imported.status()) == name) return imported;
    return WithFieldPrefix(imported.status(), name + ": ");
  } catch (const std::bad_alloc&) {
    // What a library asks for by a file's word may be more than there is.
    return FieldError(absl::StatusCode::kResourceExhausted, "TOO_LARGE", name,
                      "found more than memory holds, need a smaller scene");
  }
}

SceneDelta ToSceneDelta(const ImportedScene& imported) {
  SceneDelta delta;
  delta.upsert_instances = imported.instances;
  delta.upsert_lights = imported.lights;
  return delta;
}

Aabb Bounds(const ImportedScene& imported) {
  Aabb bounds;
  for (const Instance& instance : imported.instances) {
    // Vertex by vertex: the box of a turned box is larger than what is in it, and a floor goes
    // under this one.
    for (const Vec3& position : instance.mesh->positions()) {
      bounds.Add(TransformPoint(instance.world_from_mesh, position));
    }
  }
  return bounds;
}

}  // namespace penumbra
