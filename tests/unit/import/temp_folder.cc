#include "tests/unit/import/temp_folder.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <fstream>

namespace penumbra {

TempFolder::TempFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "penumbra_import_XXXXXX").string();
  path_ = mkdtemp(name.data());
}

TempFolder::~TempFolder() { std::filesystem::remove_all(path_); }

std::filesystem::path TempFolder::Write(const std::string& name, std::string_view bytes) const {
  const std::filesystem::path path = path_ / name;
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

absl::StatusOr<ImportedScene> ImportBytes(const std::string& name, std::string_view bytes) {
  const TempFolder folder;
  return ImportScene(folder.Write(name, bytes));
}

Instance InstanceOf(const ImportedScene& scene, std::string_view id) {
  for (const Instance& instance : scene.instances) {
    if (instance.id == id) return instance;
  }
  ADD_FAILURE() << "no instance " << id;
  return {.mesh = Mesh::Create({}).value()};
}

AreaLight LightOf(const ImportedScene& scene, std::string_view id) {
  for (const AreaLight& light : scene.lights) {
    if (light.id == id) return light;
  }
  ADD_FAILURE() << "no light " << id;
  return {};
}

Vec3 WorldVertex(const Instance& instance, size_t i) {
  if (i >= instance.mesh->positions().size()) {
    ADD_FAILURE() << instance.id << " has no vertex " << i;
    return Vec3(0.0f);
  }
  return TransformPoint(instance.world_from_mesh, instance.mesh->positions()[i]);
}

}  // namespace penumbra
