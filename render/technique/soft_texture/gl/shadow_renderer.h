// Soft shadows of many receivers, drawn by GL.
//
//   auto renderer = ShadowRenderer::Of(context);
//   auto sums = (*renderer)->Draw(context, requests, stop);   // one wait for all of them
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <stop_token>
#include <tuple>
#include <vector>

#include "absl/status/statusor.h"
#include "render/gl/context.h"
#include "render/gl/framebuffer.h"
#include "render/gl/program.h"
#include "render/gl/readback.h"
#include "render/gl/vertex_array.h"
#include "render/gl/work_pace.h"
#include "render/light_view/gl/mesh_store.h"
#include "render/technique/soft_texture/gl/pages.h"
#include "render/technique/soft_texture/gl/shadow_work.h"

namespace penumbra::texture_gl {

// Belongs to one context, on whose thread it is used, and goes with it. Keeps meshes and masks
// between calls, programs, and the targets of the last sizes.
class ShadowRenderer {
 public:
  // The one of `context`, made on first use. Errors  kInternal: a shader does not compile
  static absl::StatusOr<ShadowRenderer*> Of(gl::Context& context);

  // Shapes  N requests → N sums
  // Errors  kCancelled: stop requested, asked once a sample and every 20 ms or so;
  //         kResourceExhausted: GL_MEMORY, or out of memory; kUnavailable: the context is lost
  // Cost    O(samples · (triangles + candidate texels)); of GPU memory, besides the meshes kept,
  //         that of a few pages
  absl::StatusOr<std::vector<ShadowSums>> Draw(gl::Context& context,
                                               std::span<const ShadowRequest> requests,
                                               const std::stop_token& stop);

  const MeshStore& meshes() const { return *meshes_; }

 private:
  struct Targets {
    gl::Framebuffer shadows, sums;
  };
  explicit ShadowRenderer(MeshStore& meshes) : meshes_(&meshes) {}

  absl::Status CreatePrograms(gl::Context& context);
  absl::StatusOr<Targets*> TargetsFor(gl::Context& context, const Page& page, bool shades);
  absl::StatusOr<gl::Readback> DrawPage(gl::Context& context, const Page& page,
                                        std::span<const ShadowWork> works, bool shades,
                                        const std::stop_token& stop);
  absl::Status DrawTile(gl::Context& context, const Tile& tile, const ShadowWork& work, size_t pass,
                        gl::Framebuffer& shadows, const std::stop_token& stop);
  absl::StatusOr<gl::Program*> BindCaster(gl::Context& context, const Caster& caster);
  // texels  that its shadow covers, about
  absl::Status DrawCaster(gl::Context& context, const Caster& caster, gl::Framebuffer& shadows,
                          const gl::PixelArea& area, int samples, double texels,
                          const std::stop_token& stop);
  absl::Status Resolve(gl::Context& context, const Tile& tile, const ShadowWork& work, size_t pass,
                       bool shades, Targets& targets, const std::stop_token& stop);

  MeshStore* const meshes_;  // the context's
  gl::VertexArray no_attributes_;
  gl::Program opaque_, masked_, count_, shade_;
  gl::WorkPace pace_;
  // By width, height and whether radiance is summed up.
  std::map<std::tuple<uint32_t, uint32_t, bool>, Targets> targets_;
};

}  // namespace penumbra::texture_gl
