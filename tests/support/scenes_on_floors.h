// Scenes of other authors, each on a floor under a lamp.
//
//   for (const auto& [name, path] : kScenesOnFloors) LoadOnFloor(ScenesFolder(fallback) / path);
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "render/scene/scene.h"
#include "tests/support/scenes_folder.h"

namespace penumbra::testing {

// Of the scene, its names in tests and benchmarks, and its file in the folder of scenes.
struct SceneFile {
  const char* name;
  const char* path;
};

inline constexpr SceneFile kScenesOnFloors[] = {
    {"garden", "bridge-garden/scene.glb"},
    {"flower", "flower/flower_blue.glb"},
    {"plants", "plants-unclear-licence/plants.gltf"},
    {"dragon", "stanford-dragon-res2/dragon_vrip_res2.ply"},
};

// The instances in `file`, "floor" below them, three times as wide, and the one-sided rectangle
// "lamp" as far above them as they are wide, and half as wide.
//
// Errors  those of ImportScene and Scene::Apply
absl::StatusOr<std::shared_ptr<const Scene>> LoadOnFloor(const std::filesystem::path& file);
std::shared_ptr<const Scene> OnFloor(std::vector<Instance> instances);

}  // namespace penumbra::testing
