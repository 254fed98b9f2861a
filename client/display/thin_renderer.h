// Draws a scene with the shadows that were received for it: the surfaces are lit here, in closed
// form, and only how much of each light they see comes from artifacts.
//
//   auto renderer = ThinRenderer::Create(context);
//   auto picture = (*renderer)->Render(context, scene, artifacts, camera, {.width = 1280});
//
// Surfaces without an artifact are lit as if nothing were in the way, by the same formula, so both
// match where nothing is.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#include "absl/status/statusor.h"
#include "client/display/picture.h"
#include "client/display/surface_glsl.h"
#include "client/display/volume_look.h"
#include "render/artifact/artifact.h"
#include "render/gl/context.h"
#include "render/scene/camera.h"
#include "render/scene/scene.h"

namespace penumbra {

struct RenderOptions {
  int width = 1280;  // pixels, 1 to 16,384
  int height = 720;
  int samples_per_side = 2;  // n × n shading samples a pixel, each with 4 edge samples; 1 to 8
  Vec3 ambient{0.0f};        // radiance that reaches every surface from everywhere
  bool draws_lights = true;  // rectangles, disks and spheres as the glowing things they are
  // Radiance is cut to this before samples are averaged. For a screen take 1 / exposure, which
  // keeps the edges of bright lights smooth.
  float clip_radiance = std::numeric_limits<float>::infinity();
  VolumeLook volume_look;
  bool culls_back_faces = false;  // leave out faces that turn away, to look into a closed room
};

// Keeps meshes, masks and artifacts on the GPU from one picture to the next and uploads what is
// new. All calls with contexts of one thread; after a context is lost, with the next one.
class ThinRenderer {
 public:
  // How many objects were uploaded since this renderer was made.
  struct Uploads {
    int64_t meshes = 0;
    int64_t masks = 0;
    int64_t artifacts = 0;
  };

  // surface  what draws faces: SurfaceProgram(), or one that finds shadows in another way
  // Errors   kInternal: the driver does not take the shaders
  static absl::StatusOr<std::unique_ptr<ThinRenderer>> Create(
      gl::Context& context, gl::ProgramSource surface = SurfaceProgram());
  ~ThinRenderer();

  // Artifacts of lights or receivers that `scene` does not hold are ignored; so are nulls.
  //
  // Errors  kInvalidArgument: the camera, or an option; kResourceExhausted: GPU memory;
  //         kUnavailable: the context is lost
  absl::StatusOr<Picture> Render(gl::Context& context, const Scene& scene,
                                 std::span<const std::shared_ptr<const Artifact>> artifacts,
                                 const Camera& camera, const RenderOptions& options = {});

  Uploads uploads() const;

 private:
  class Impl;
  explicit ThinRenderer(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace penumbra
