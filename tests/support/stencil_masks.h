// The shadow that the thin client's stencil has of a shadow volume mesh.
//
//   StencilMasks masks(*context);
//   std::vector<uint8_t> dark = masks.MaskOf(*scene, artifact, eye);
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "client/display/cover_sheet.h"
#include "client/display/surface_painter.h"
#include "client/display/volume_shadows.h"
#include "render/artifact/artifact.h"
#include "render/gl/context.h"
#include "render/scene/scene.h"
#include "tests/support/volume_crossings.h"

namespace penumbra::testing {

class StencilMasks {
 public:
  // Refers to the context. Whatever goes wrong ends the program.
  explicit StencilMasks(gl::Context& context);

  // One a pixel, in the order of EyeImage; 1 where the surface is in shadow, 0 also where there is
  // none.
  //
  // artifact  a shadow volume mesh of a light of `scene`
  std::vector<uint8_t> MaskOf(const Scene& scene, const std::shared_ptr<const Artifact>& artifact,
                              const EyeImage& eye);

 private:
  gl::Context& context_;
  SurfacePainter painter_;
  VolumeShadows volumes_;
  CoverSheet sheet_;
  std::optional<gl::Framebuffer> target_;
};

// A mesh as the artifact of light "light" of a scene that has it.
std::shared_ptr<const Artifact> ArtifactOf(ShadowVolumeMesh mesh);
// The scene with the mesh's light, called "light".
std::shared_ptr<const Scene> WithLight(const Scene& scene, AreaLight light);

}  // namespace penumbra::testing
