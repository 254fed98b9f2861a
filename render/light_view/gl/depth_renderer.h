// What a GL context keeps to draw depth maps with.
//
//   auto renderer = DepthRenderer::Of(context);
//   auto pixels = (*renderer)->Draw(context, casters, view, rows, field, stop);   // on their way
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "render/artifact/light_view.h"
#include "render/gl/context.h"
#include "render/gl/framebuffer.h"
#include "render/gl/program.h"
#include "render/gl/readback.h"
#include "render/gl/vertex_array.h"
#include "render/gl/work_pace.h"
#include "render/light_view/gl/depth_glsl.h"
#include "render/light_view/gl/mesh_store.h"
#include "render/math/aabb.h"
#include "render/scene/instance.h"

namespace penumbra {

struct GlCaster {
  std::shared_ptr<const Instance> instance;
  Aabb box;  // in world space, with room for what its corners are rounded by
};

// Rows [first, first + count) of a view.
struct RowBand {
  uint32_t first = 0, count = 0;
};

// Belongs to one context, on whose thread it is used, and goes with it.
class DepthRenderer {
 public:
  // The one of `context`, made on first use. Errors  kInternal: a shader does not compile
  static absl::StatusOr<DepthRenderer*> Of(gl::Context& context);

  // Before the first of several bands.
  void Begin(const gl::Context& context) { pace_.Start(context); }

  // Draws a band of a view, which is not empty, and sends for its pixels without waiting.
  //
  // Shapes  → count·width values, as DepthProgram writes them; those below kUnseen saw nothing
  // Errors  kCancelled: stop requested, asked every 20 ms or so; kResourceExhausted: GL_MEMORY at
  //         `field`, or out of memory; kUnavailable: the context is lost
  absl::StatusOr<gl::Readback> Draw(gl::Context& context, std::span<const GlCaster> casters,
                                    const LightView& view, RowBand band, std::string_view field,
                                    const std::stop_token& stop);

  // Less than what anything within the limits of coordinates is seen at.
  static constexpr float kUnseen = -3e38f;

 private:
  DepthRenderer() = default;
  absl::Status CreatePrograms(gl::Context& context);
  absl::StatusOr<gl::Framebuffer*> TargetFor(gl::Context& context, int width, int height);
  absl::Status DrawCaster(gl::Context& context, const Instance& instance, gl::Framebuffer& target,
                          const gl::PixelArea& area, double pixels, std::string_view field,
                          const std::stop_token& stop);

  MeshStore* meshes_ = nullptr;  // the context's
  gl::VertexArray no_attributes_;
  gl::Program opaque_, masked_;
  gl::WorkPace pace_;
  // Drawn to in turn: while the one is read the other is drawn to.
  std::array<std::optional<gl::Framebuffer>, 2> targets_;
  size_t next_target_ = 0;
};

}  // namespace penumbra
