// Reads scene files: glTF 2.0 (.gltf, .glb), Wavefront OBJ and PLY.
//
//   auto imported = ImportScene("table.glb");
//   if (!imported.ok()) return imported.status();  // "table.glb: accessors[3].bufferView: found 9,
//   …" scene = scene->Apply(ToSceneDelta(*imported));
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "render/math/vec.h"
#include "render/scene/area_light.h"
#include "render/scene/instance.h"
#include "render/scene/scene.h"
#include "render/scene/scene_limits.h"

namespace penumbra {

// A perspective camera that the file holds.
struct ImportedCamera {
  std::string id;  // as for instances; unique among the file's cameras
  Vec3 position{0.0f};
  Vec3 forward{0, 0, -1};      // unit length
  Vec3 up{0, 1, 0};            // unit length, at right angles to `forward`
  float fov_y = 0.785398163f;  // radians, the whole vertical opening
};

// Everything in world space: metres, +Y up, right-handed. Ids come from the file's names and are
// the same each time the file is read. Instances of one mesh share it.
struct ImportedScene {
  std::vector<Instance> instances;
  std::vector<AreaLight> lights;
  std::vector<ImportedCamera> cameras;
  // What the file holds and the scene does not, one line each: "materials[2]: …".
  std::vector<std::string> warnings;
};

// Reads the file at `path`. What it is, its first bytes say, or else its extension. Other files are
// opened only if a relative URI names them and they lie in the folder of `path` or below it;
// nothing is ever fetched. docs/scene-files.md lists what is read and how units are taken.
//
// Errors  kNotFound: no such file, or one that it names; kPermissionDenied: cannot be read, or a
// URI
//         leads out of the folder; kInvalidArgument: malformed, the message names the field;
//         kUnimplemented: needs an extension that is not supported; kResourceExhausted: over a
//         limit
absl::StatusOr<ImportedScene> ImportScene(const std::filesystem::path& path,
                                          const SceneLimits& limits = {});

// The batch that puts all instances and lights of `imported` into a scene, at any base revision.
SceneDelta ToSceneDelta(const ImportedScene& imported);

// Around all instances that have vertices, in world space.
Aabb Bounds(const ImportedScene& imported);

}  // namespace penumbra
