// Pictures of a scene with its shadows, drawn in this process and written to a file.
//
//   auto pencil = Pencil::Create();
//   auto drawn = (*pencil)->Draw(scene, shadows, {.camera = camera}, "view.png");
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cli/draw_room.h"
#include "client/cli/numbers.h"
#include "client/display/volume_look.h"
#include "client/import/import_scene.h"
#include "render/artifact/artifact.h"
#include "render/scene/camera.h"
#include "render/scene/scene.h"

namespace penumbra {

using Shadows = std::vector<std::shared_ptr<const Artifact>>;

struct DrawRequest {
  GridSize size{960, 640};
  Camera camera;
  std::optional<Vec3> ambient;    // absent: a share of the light there is
  std::optional<float> exposure;  // absent: found from the picture
  VolumeLook volume_look;
  bool culls_back_faces = false;
};

struct DrawnPicture {
  Camera camera;
  float exposure = 1.0f;
  std::string renderer;  // the GL device
  double draw_ms = 0.0;  // without writing the file
};

// Errors  kInvalidArgument: neither .png nor .exr
absl::Status CheckPicturePath(const std::filesystem::path& path);

// The file's first camera, or else one that has everything in sight; with a floor, some of that.
Camera ChooseCamera(const ImportedScene& imported, bool has_floor, GridSize size);

// One GL context and what was uploaded to it. On one thread.
class Pencil {
 public:
  // Errors  kUnavailable: no EGL device
  static absl::StatusOr<std::unique_ptr<Pencil>> Create();
  virtual ~Pencil() = default;

  // For all that says of any surface what it sees of the lights.
  virtual DrawRoom room() const = 0;

  // Draws and writes: .png toned in sRGB, .exr in linear light.
  virtual absl::StatusOr<DrawnPicture> Draw(const Scene& scene, const Shadows& shadows,
                                            const DrawRequest& request,
                                            const std::filesystem::path& path) = 0;
};

}  // namespace penumbra
