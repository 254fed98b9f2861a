// A polygon over the whole picture, for what is done to all of its surfaces at once.
//
//   auto sheet = CoverSheet::Create(context);
//   sheet->Draw(context, target, Vec4(0, 0, 0, 1), {.combine = gl::Combine::kMultiplyByAlpha});
#pragma once

#include "absl/status/statusor.h"
#include "render/gl/draw.h"
#include "render/gl/program.h"
#include "render/gl/vertex_array.h"

namespace penumbra {

class CoverSheet {
 public:
  struct How {
    gl::Combine combine = gl::Combine::kReplace;
    gl::Stencil stencil = gl::Stencil::kNone;
  };

  // Errors  kInternal: the driver does not take the shaders
  static absl::StatusOr<CoverSheet> Create(gl::Context& context);

  // Where there is a surface: behind all of them, and before none.
  void Draw(gl::Context& context, gl::Framebuffer& target, Vec4 color, const How& how);

 private:
  CoverSheet(gl::Program program, gl::VertexArray corners)
      : program_(std::move(program)), corners_(std::move(corners)) {}

  gl::Program program_;
  gl::VertexArray corners_;  // none: the shader knows them
};

}  // namespace penumbra
