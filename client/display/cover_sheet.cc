#include "client/display/cover_sheet.h"

#include <utility>

namespace penumbra {
namespace {

// Infinitely far: depth is reversed.
constexpr char kVertexGlsl[] = R"glsl(
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(corner, 0.0, 1.0);
}
)glsl";

constexpr char kFragmentGlsl[] = R"glsl(
uniform vec4 color;
layout(location = 0) out vec4 pixel;
void main() { pixel = color; }
)glsl";

}  // namespace

absl::StatusOr<CoverSheet> CoverSheet::Create(gl::Context& context) {
  auto program = gl::Program::Create(context, {.vertex = kVertexGlsl, .fragment = kFragmentGlsl});
  if (!program.ok()) return program.status();
  auto corners = gl::VertexArray::Create(context);
  if (!corners.ok()) return corners.status();
  return CoverSheet(*std::move(program), *std::move(corners));
}

void CoverSheet::Draw(gl::Context& context, gl::Framebuffer& target, Vec4 color, const How& how) {
  program_.Set(context, "color", color);
  gl::Draw(context, {.program = program_,
                     .vertices = corners_,
                     .target = target,
                     .count = 3,
                     .depth_test = gl::DepthTest::kFarther,
                     .writes_depth = false,
                     .combine = how.combine,
                     .stencil = how.stencil});
}

}  // namespace penumbra
