#include "client/display/visibility_glsl.h"

#include <algorithm>

#include "absl/strings/str_cat.h"

namespace penumbra {
namespace {

// Share of a receiver's longer edge by which a surface may leave its plane and still be the
// receiver: what BoundingParallelogram allows to a planar instance.
constexpr double kPlaneTolerance = 1e-4;

constexpr char kGlsl[] = R"glsl(
struct Receiver {
  vec4 origin;
  vec4 dual_u;
  vec4 dual_v;
  vec4 normal;
  uvec4 texels;  // first, width, height, sample count
};

vec2 UvOnReceiver(Receiver receiver, vec3 point) {
  vec3 d = point - receiver.origin.xyz;
  return vec2(dot(receiver.dual_u.xyz, d), dot(receiver.dual_v.xyz, d));
}

float FractionAt(Receiver receiver, ivec2 texel) {
  ivec2 last = ivec2(receiver.texels.yz) - 1;
  uvec2 inside = uvec2(clamp(texel, ivec2(0), last));
  uint index = receiver.texels.x + inside.y * receiver.texels.y + inside.x;
  uint count = (counts[index >> 1] >> (16u * (index & 1u))) & 0xffffu;
  return receiver.texels.w == 0u ? 1.0 : float(count) / float(receiver.texels.w);
}

float Visibility(Receiver receiver, vec2 uv) {
  return FractionAt(receiver, ivec2(floor(clamp(uv, -1.0, 2.0) * vec2(receiver.texels.yz))));
}

float SmoothVisibility(Receiver receiver, vec2 uv) {
  vec2 place = clamp(uv, -1.0, 2.0) * vec2(receiver.texels.yz) - 0.5;
  ivec2 low = ivec2(floor(place));
  vec2 share = place - vec2(low);
  float below = mix(FractionAt(receiver, low), FractionAt(receiver, low + ivec2(1, 0)), share.x);
  float above = mix(FractionAt(receiver, low + ivec2(0, 1)), FractionAt(receiver, low + ivec2(1, 1)), share.x);
  return mix(below, above, share.y);
}
)glsl";

}  // namespace

GpuReceiver ToGpu(const SoftShadowTexture& texture, uint32_t first_texel) {
  const Parallelogram& patch = texture.receiver.patch;
  const DVec3 u(patch.edge_u), v(patch.edge_v);
  const DVec3 normal = glm::normalize(glm::cross(u, v));
  const double tolerance = kPlaneTolerance * std::max(glm::length(u), glm::length(v));
  const DVec3 across_v = glm::cross(v, normal), across_u = glm::cross(normal, u);
  const VisibilityMap& map = texture.visibility;
  return {.origin = Vec4(patch.origin, static_cast<float>(tolerance)),
          .dual_u = Vec4(Vec3(across_v / glm::dot(u, across_v)), 0),
          .dual_v = Vec4(Vec3(across_u / glm::dot(v, across_u)), 0),
          .normal = Vec4(Vec3(normal), texture.receiver.two_sided ? 1.0f : 0.0f),
          .first_texel = first_texel,
          .width = map.width,
          .height = map.height,
          .sample_count = map.sample_count};
}

std::string VisibilityGlsl(int counts_binding) {
  return absl::StrCat("layout(std430, binding = ", counts_binding,
                      ") readonly buffer Counts { uint counts[]; };\n", kGlsl);
}

}  // namespace penumbra
