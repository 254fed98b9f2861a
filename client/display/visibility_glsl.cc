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
  uvec4 mask;    // first word, 1 if there is one
};

vec2 AcrossReceiver(Receiver receiver, vec3 d) {
  return vec2(dot(receiver.dual_u.xyz, d), dot(receiver.dual_v.xyz, d));
}

vec2 UvOnReceiver(Receiver receiver, vec3 point) {
  return AcrossReceiver(receiver, point - receiver.origin.xyz);
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

bool IsInside(Receiver receiver, ivec2 texel) {
  uvec2 inside = uvec2(clamp(texel, ivec2(0), ivec2(receiver.texels.yz) - 1));
  uint bit = inside.y * receiver.texels.y + inside.x;
  return ((counts[receiver.mask.x + (bit >> 5)] >> (bit & 31u)) & 1u) != 0u;
}

int Coverage(Receiver receiver, vec2 uv) {
  if (receiver.mask.y == 0u) return 3;
  vec2 place = clamp(uv, -1.0, 2.0) * vec2(receiver.texels.yz);
  ivec2 here = ivec2(floor(place));
  if (IsInside(receiver, here)) return 3;
  ivec2 low = ivec2(floor(place - 0.5));
  if (IsInside(receiver, low) || IsInside(receiver, low + ivec2(1, 0)) || IsInside(receiver, low + ivec2(0, 1)) ||
      IsInside(receiver, low + ivec2(1, 1))) return 2;
  for (int reach = 1; reach <= 12; reach += 1 + reach / 2) {
    for (int side = 0; side < 9; ++side) {
      if (IsInside(receiver, here + reach * (ivec2(side % 3, side / 3) - 1))) return 1;
    }
  }
  return 0;
}
)glsl";

uint32_t EvenCount(size_t count) { return static_cast<uint32_t>((count + 1) / 2 * 2); }

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
          .sample_count = map.sample_count,
          .first_mask_word = (first_texel + EvenCount(map.counts.size())) / 2,
          .has_mask = texture.coverage != nullptr ? 1u : 0u};
}

size_t PlacesOf(const SoftShadowTexture& texture) {
  constexpr size_t kBytesPerWord = 4;  // two places
  const size_t mask_bytes = texture.coverage ? texture.coverage->bytes().size() : 0;
  return EvenCount(texture.visibility.counts.size()) +
         2 * ((mask_bytes + kBytesPerWord - 1) / kBytesPerWord);
}

std::string VisibilityGlsl(int counts_binding) {
  return absl::StrCat("layout(std430, binding = ", counts_binding,
                      ") readonly buffer Counts { uint counts[]; };\n", kGlsl);
}

}  // namespace penumbra
