// A folder that lives as long as a test.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "client/import/import_scene.h"

namespace penumbra {

class TempFolder {
 public:
  TempFolder();
  ~TempFolder();
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  // Writes a file, in a folder below where `name` has one.
  std::filesystem::path Write(const std::string& name, std::string_view bytes) const;

 private:
  std::filesystem::path path_;
};

// Imports `bytes` as a file called `name`.
absl::StatusOr<ImportedScene> ImportBytes(const std::string& name, std::string_view bytes);

// The instance of that id; a failure of the test and an empty one where there is none.
Instance InstanceOf(const ImportedScene& scene, std::string_view id);
AreaLight LightOf(const ImportedScene& scene, std::string_view id);

// Vertex `i` of `instance`, in the world.
Vec3 WorldVertex(const Instance& instance, size_t i);

}  // namespace penumbra
