// Reads PLY: ASCII and binary of both byte orders.
#pragma once

#include <filesystem>

#include "absl/status/statusor.h"
#include "client/import/import_scene.h"

namespace penumbra {

// As ImportScene, for a file that is known to be PLY: one instance, named after the file. Polygons
// are cut into fans; triangle strips and all elements but `vertex` and `face` are left out.
absl::StatusOr<ImportedScene> ImportPly(const std::filesystem::path& path,
                                        const SceneLimits& limits);

}  // namespace penumbra
