// Visibility() of render/artifact/artifact.h in GLSL, and how receivers and their counts are handed
// to it.
#pragma once

#include <cstdint>
#include <string>

#include "render/artifact/soft_shadow_texture.h"
#include "render/math/vec.h"

namespace penumbra {

// A receiver with the counts of one light as a shader sees them, std430.
struct GpuReceiver {
  Vec4 origin{0};  // w: how far off the plane a point still lies on the receiver, in metres
  Vec4 dual_u{0};  // u = dual_u · (point − origin), of the point's parallel projection
  Vec4 dual_v{0};
  Vec4 normal{0};  // of the front, unit length; w: 1 if two-sided
  uint32_t first_texel = 0;
  uint32_t width = 0;
  uint32_t height = 0;
  uint32_t sample_count = 0;
};

// `first_texel`: where the counts begin in the buffer of 16-bit counts.
GpuReceiver ToGpu(const SoftShadowTexture& texture, uint32_t first_texel);

// GLSL that declares `struct Receiver` and, on a storage block `uint counts[]` at `counts_binding`
// with two counts a word, the lower half first:
//
//   vec2 UvOnReceiver(Receiver receiver, vec3 point)
//   float Visibility(Receiver receiver, vec2 uv)           the texel that holds uv, as the C++ has
//   it float SmoothVisibility(Receiver receiver, vec2 uv)     between the four nearest texel
//   centres
std::string VisibilityGlsl(int counts_binding);

}  // namespace penumbra
