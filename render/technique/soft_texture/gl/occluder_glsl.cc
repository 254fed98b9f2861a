#include "render/technique/soft_texture/gl/occluder_glsl.h"

#include "absl/strings/str_cat.h"
#include "render/technique/soft_texture/coverage_kernel.h"
#include "render/technique/soft_texture/gl/occluder_vertex_glsl.h"

namespace penumbra::texture_gl {
namespace {

// Below this w a point is taken to be level with the light, as on the CPU (careful_triangle.cc).
constexpr double kSmallestW = 0x1.0p-16;

// Texels by which a triangle is made larger to be sure of its candidates: GL promises a grid of
// 1/16 of a texel, on which a vertex moves by half as much, and single precision at kFarTexels adds
// less than that again.
constexpr double kMargin = 0.125;

// Further out than this, triangles are not drawn as such: their candidates are all texels.
constexpr double kFarTexels = 65536;

constexpr char kInputs[] = R"glsl(
flat in vec3 edge[3];
flat in vec2 from[3];
flat in vec3 scale, corner_w, corner_height;
flat in ivec2 is_cut;
flat in float surface_offset;
flat in uvec2 bit;

uniform ivec2 slot, rows;

layout(location = 0) out uvec2 shadows;

)glsl";

constexpr char kNoMask[] = "bool IsHole(vec3 share) { return false; }\n";

// AlphaMask::At and its RepeatedTexel.
constexpr char kMask[] = R"glsl(
flat in vec2 corner_uv[3];
layout(binding = kMaskUnit) uniform usampler2D mask;
uniform int least_alpha;

int RepeatedTexel(float t, int count) {
  float wrapped = t - floor(t);
  if (!(wrapped >= 0.0)) return 0;
  return min(int(wrapped * float(count)), count - 1);
}

bool IsHole(vec3 share) {
  vec2 uv = share.x * corner_uv[0] + share.y * corner_uv[1] + share.z * corner_uv[2];
  ivec2 mask_size = textureSize(mask, 0);
  ivec2 at = ivec2(RepeatedTexel(uv.x, mask_size.x), RepeatedTexel(uv.y, mask_size.y));
  return int(texelFetch(mask, at, 0).r) < least_alpha;
}
)glsl";

constexpr char kMain[] = R"glsl(
// A texel centre on an edge belongs to the triangle on one side of it: left and lower edges are
// part of a triangle, right and upper ones are not.
bool OwnsCenter(float value, vec3 line, float side) {
  return value != 0.0 || line.x * side > 0.0 || (line.x == 0.0 && line.y * side > 0.0);
}

void main() {
  vec2 texel = floor(gl_FragCoord.xy) - vec2(slot) + vec2(0.0, rows.x);
  vec3 inside;
  for (int k = 0; k < 3; ++k) {
    precise float value = edge[k].x * (texel.x - from[k].x) + edge[k].y * (texel.y - from[k].y) +
                          edge[k].z;
    inside[k] = value;
  }
  bool is_left = any(greaterThan(inside, vec3(0.0))), is_right = any(lessThan(inside, vec3(0.0)));
  if (is_left == is_right) discard;
  float side = is_left ? 1.0 : -1.0;
  if (!OwnsCenter(inside.x, edge[0], side) || !OwnsCenter(inside.y, edge[1], side) ||
      !OwnsCenter(inside.z, edge[2], side)) {
    discard;
  }
  vec3 share = inside * scale;
  share /= share.x + share.y + share.z;
  if (is_cut.x != 0 && !(dot(share, corner_w) >= float(kSmallestW))) discard;
  if (is_cut.y != 0 && !(dot(share, corner_height) > surface_offset)) discard;
  if (IsHole(share)) discard;
  shadows = bit;
}
)glsl";

}  // namespace

gl::ProgramSource OccluderProgram(bool masked) {
  return {.vertex = OccluderVertexGlsl(masked),
          .fragment = absl::StrCat(kInputs, masked ? kMask : kNoMask, kMain),
          .constants = absl::StrCat(gl::GlslConstant("kSmallestW", kSmallestW),
                                    gl::GlslConstant("kSamplesPerPass", kSamplesPerPass),
                                    gl::GlslConstant("kMargin", kMargin),
                                    gl::GlslConstant("kFarTexels", kFarTexels),
                                    gl::GlslConstant("kNearLightW", kNearLightW),
                                    gl::GlslConstant("kPositionsBinding", kPositionsBinding),
                                    gl::GlslConstant("kIndicesBinding", kIndicesBinding),
                                    gl::GlslConstant("kUvsBinding", kUvsBinding),
                                    gl::GlslConstant("kMapsBinding", kMapsBinding),
                                    gl::GlslConstant("kMaskUnit", kMaskUnit))};
}

}  // namespace penumbra::texture_gl
