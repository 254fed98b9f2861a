#include "render/technique/soft_texture/gl/resolve_glsl.h"

#include "absl/strings/str_cat.h"
#include "render/technique/soft_texture/gl/occluder_glsl.h"
#include "render/technique/soft_texture/gl/sample_term.h"

namespace penumbra::texture_gl {
namespace {

constexpr char kVertex[] = R"glsl(
void main() {
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
)glsl";

constexpr char kInputs[] = R"glsl(
layout(binding = kShadowsUnit) uniform usampler2D shadows;

uvec2 Shadows() { return texelFetch(shadows, ivec2(gl_FragCoord.xy), 0).rg; }

float HiddenCount(uvec2 bits) { return float(bitCount(bits.x) + bitCount(bits.y)); }
)glsl";

constexpr char kCount[] = R"glsl(
layout(location = 0) out float hidden;
void main() { hidden = HiddenCount(Shadows()); }
)glsl";

constexpr char kShade[] = R"glsl(
layout(std140, binding = kLightSamplesBinding) uniform LightSamples {
  Emitter emitter;
  LightSample samples[kSamplesPerPass];
};
uniform ivec2 slot, rows, size;
uniform vec3 edge_u, edge_v, normal, reflectance;
uniform int sample_count, two_sided;

layout(location = 0) out vec4 sums;

void main() {
  uvec2 bits = Shadows();
  vec2 texel = floor(gl_FragCoord.xy) - vec2(slot) + vec2(0.0, rows.x);
  vec2 uv = (texel + 0.5) / vec2(size);
  vec3 point = uv.x * edge_u + uv.y * edge_v;
  float sum = 0.0;
  for (int s = 0; s < sample_count; ++s) {
    uint word = s < 32 ? bits.x : bits.y;
    if ((word >> (s & 31) & 1u) != 0u) continue;
    sum += SampleTerm(samples[s], emitter, point, normal, two_sided != 0);
  }
  sums = vec4(sum * emitter.emission.rgb * reflectance, HiddenCount(bits));
}
)glsl";

}  // namespace

gl::ProgramSource ResolveProgram(bool shades) {
  return {
      .vertex = kVertex,
      .fragment = absl::StrCat(shades ? SampleTermGlsl() : "", kInputs, shades ? kShade : kCount),
      .constants = absl::StrCat(gl::GlslConstant("kShadowsUnit", kShadowsUnit),
                                gl::GlslConstant("kSamplesPerPass", kSamplesPerPass),
                                gl::GlslConstant("kLightSamplesBinding", kLightSamplesBinding))};
}

}  // namespace penumbra::texture_gl
