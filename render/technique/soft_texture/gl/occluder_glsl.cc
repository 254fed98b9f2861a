#include "render/technique/soft_texture/gl/occluder_glsl.h"

#include "absl/strings/str_cat.h"
#include "render/light_view/gl/mesh_store.h"
#include "render/light_view/gl/triangle_glsl.h"
#include "render/technique/soft_texture/coverage_kernel.h"
#include "render/technique/soft_texture/gl/occluder_vertex_glsl.h"

namespace penumbra::texture_gl {
namespace {

// Below this w a point is taken to be level with the light, as on the CPU (careful_triangle.cc).
constexpr double kSmallestW = 0x1.0p-16;

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

constexpr char kMask[] = R"glsl(
flat in vec2 corner_uv[3];

bool IsHole(vec3 share) {
  return IsHoleAt(share.x * corner_uv[0] + share.y * corner_uv[1] + share.z * corner_uv[2]);
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
          .fragment = masked ? absl::StrCat(kInputs, AlphaMaskGlsl(), kMask, kMain)
                             : absl::StrCat(kInputs, kNoMask, kMain),
          .constants = absl::StrCat(gl::GlslConstant("kSmallestW", kSmallestW),
                                    gl::GlslConstant("kSamplesPerPass", kSamplesPerPass),
                                    gl::GlslConstant("kFarTexels", kFarTexels),
                                    gl::GlslConstant("kNearLightW", kNearLightW),
                                    gl::GlslConstant("kPositionsBinding", kPositionsBinding),
                                    gl::GlslConstant("kIndicesBinding", kIndicesBinding),
                                    gl::GlslConstant("kUvsBinding", kUvsBinding),
                                    gl::GlslConstant("kMapsBinding", kMapsBinding))};
}

}  // namespace penumbra::texture_gl
