// A colour image to draw into, and a depth image unless it is left out.
//
//   auto target = gl::Framebuffer::Create(context, {.width = 512, .height = 512, .samples = 4});
//   target->Clear(context, {0, 0, 0, 0});
//   … draw …
//   auto pixels = target->ReadPixels(context);   // 4 · 512 · 512 floats, row 0 at the bottom
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "render/gl/context.h"
#include "render/gl/texture.h"
#include "render/math/vec.h"

namespace penumbra::gl {

struct FramebufferOptions {
  int width = 0;
  int height = 0;
  Format color = Format::kRgba32F;
  int samples = 1;
  bool has_depth = true;
  bool has_stencil = false;  // with depth only
};

class Framebuffer {
 public:
  // Errors  those of Texture::Create; kUnavailable: the driver cannot draw into such images
  static absl::StatusOr<Framebuffer> Create(Context& context, const FramebufferOptions& options);

  const FramebufferOptions& options() const { return options_; }
  uint32_t name() const { return name_.get(); }

  // Depth is cleared to 0, the far end: depth is reversed throughout (see draw.h).
  void Clear(Context& context, Vec4 color);
  // The same for a colour image of whole numbers: all zeros.
  void ClearToZeros(Context& context);
  // Eight bits a sample; of nothing else.
  void ClearStencil(Context& context, uint8_t value);
  // For a program to read.
  void BindColor(Context& context, uint32_t unit) const { color_.Bind(context, unit); }

  // The colour image as RGBA, its samples averaged. Row 0 is at the bottom.
  absl::StatusOr<std::vector<Vec4>> ReadPixels(Context& context);

 private:
  FramebufferOptions options_;
  Texture color_;
  Texture depth_;
  Texture resolved_color_;  // only with several samples
  ObjectName name_;
  ObjectName resolved_name_;
};

}  // namespace penumbra::gl
