#include "render/technique/shadow_width/gl/distance_steps_glsl.h"

#include "absl/strings/str_cat.h"

namespace penumbra::width_gl {
namespace {

constexpr char kVertex[] = R"glsl(
void main() {
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
)glsl";

constexpr char kStart[] = R"glsl(
layout(binding = kSourceUnit) uniform usampler2D blocked;
layout(location = 0) out float distance_to_lit;

void main() {
  bool is_lit = texelFetch(blocked, ivec2(gl_FragCoord.xy), 0).r == 0u;
  distance_to_lit = is_lit ? 0.0 : kNowhere;
}
)glsl";

constexpr char kStep[] = R"glsl(
layout(binding = kSourceUnit) uniform sampler2D distances;
uniform ivec2 offsets[kNeighbours];
uniform float lengths[kNeighbours];
layout(location = 0) out float distance_to_lit;

void main() {
  ivec2 here = ivec2(gl_FragCoord.xy), last = textureSize(distances, 0) - 1;
  float least = texelFetch(distances, here, 0).r;
  for (int i = 0; i < kNeighbours; ++i) {
    ivec2 there = clamp(here + offsets[i], ivec2(0), last);
    least = min(least, texelFetch(distances, there, 0).r + lengths[i]);
  }
  distance_to_lit = least;
}
)glsl";

}  // namespace

gl::ProgramSource StartProgram() {
  return {.vertex = kVertex,
          .fragment = kStart,
          .constants = absl::StrCat(gl::GlslConstant("kSourceUnit", kSourceUnit),
                                    gl::GlslConstant("kNowhere", double{kNowhere}))};
}

gl::ProgramSource StepProgram(int neighbours) {
  return {.vertex = kVertex,
          .fragment = kStep,
          .constants = absl::StrCat(gl::GlslConstant("kSourceUnit", kSourceUnit),
                                    gl::GlslConstant("kNeighbours", neighbours))};
}

}  // namespace penumbra::width_gl
