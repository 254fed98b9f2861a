// Reads glTF 2.0, as text or GLB.
#pragma once

#include <filesystem>

#include "absl/status/statusor.h"
#include "client/import/import_scene.h"

namespace penumbra {

// As ImportScene, for a file that is known to be glTF.
absl::StatusOr<ImportedScene> ImportGltf(const std::filesystem::path& path,
                                         const SceneLimits& limits);

}  // namespace penumbra
