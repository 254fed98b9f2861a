// Reads Wavefront OBJ with its materials.
#pragma once

#include <filesystem>

#include "absl/status/statusor.h"
#include "client/import/import_scene.h"

namespace penumbra {

// As ImportScene, for a file that is known to be OBJ. Each object or group makes one instance, or
// one for each material it uses. Flat parallelograms and spheres that glow (Ke; or Ka above 1,
// which no reflectance is and old Cornell boxes use for it) are lights too, one-sided by their
// winding.
absl::StatusOr<ImportedScene> ImportObj(const std::filesystem::path& path,
                                        const SceneLimits& limits);

}  // namespace penumbra
