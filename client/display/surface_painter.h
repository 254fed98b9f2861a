// Draws the surfaces of a draw list, and what glows.
//
//   SurfacePainter painter(SurfaceProgram());
//   status = painter.Bind(context);
//   painter.SetFrame(context, camera, {.ambient = ambient});
//   for (const DrawItem& item : list.items) status = painter.Draw(context, item, pass);
//   painter.EndFrame();
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "absl/status/status.h"
#include "client/display/draw_list.h"
#include "client/display/gpu_mesh.h"
#include "client/display/surface_glsl.h"
#include "render/gl/draw.h"
#include "render/gl/program.h"
#include "render/scene/camera.h"

namespace penumbra {

// What all surfaces of a picture have in common.
struct SurfaceFrame {
  Vec3 ambient{0.0f};
  float clip_radiance = std::numeric_limits<float>::infinity();
  bool culls_back_faces = false;
};

// One drawing of surfaces.
struct SurfacePass {
  DMat4 clip_from_world{1.0};
  gl::Framebuffer& target;
  // Places in the order of lights (WordPool::Update); past the last.
  int first_light = 0, end_light = 0;
  bool adds_ambient = true;
  gl::DepthTest depth_test = gl::DepthTest::kNearer;
  gl::Combine combine = gl::Combine::kReplace;
  gl::Stencil stencil = gl::Stencil::kNone;
};

// Keeps meshes and masks on the GPU from one picture to the next.
class SurfacePainter {
 public:
  explicit SurfacePainter(gl::ProgramSource surface) : surface_source_(std::move(surface)) {}

  // Begins anew in a context.
  //
  // Errors  kInternal: the driver does not take the shaders
  absl::Status Bind(gl::Context& context);

  void SetFrame(gl::Context& context, const Camera& camera, const SurfaceFrame& frame);
  // Errors  kResourceExhausted: GPU memory
  absl::Status Draw(gl::Context& context, const DrawItem& item, const SurfacePass& pass);
  void EndFrame();

  int64_t mesh_upload_count() const { return meshes_.upload_count(); }
  int64_t mask_upload_count() const { return masks_.upload_count(); }

 private:
  void SetItem(gl::Context& context, const DrawItem& item, const GpuMesh& mesh,
               const SurfacePass& pass);

  const gl::ProgramSource surface_source_;
  std::optional<gl::Program> surface_, glow_;
  UploadCache<GpuMesh> meshes_;
  UploadCache<gl::Texture> masks_;
};

}  // namespace penumbra
