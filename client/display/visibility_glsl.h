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
  uint32_t first_mask_word = 0;  // 32 bits each, of the same buffer
  uint32_t has_mask = 0;
  uint32_t unused[2] = {0, 0};
};

// `first_texel`: where the counts begin in the buffer of 16-bit counts; even. The mask, where there
// is one, follows them.
GpuReceiver ToGpu(const SoftShadowTexture& texture, uint32_t first_texel);

// How many 16-bit places the counts and the mask take, an even number.
size_t PlacesOf(const SoftShadowTexture& texture);

// GLSL that declares `struct Receiver` and, on a storage block `uint counts[]` at `counts_binding`
// with two counts a word, the lower half first:
//
//   vec2 UvOnReceiver(Receiver receiver, vec3 point)
//   float Visibility(Receiver receiver, vec2 uv)           the texel that holds uv, as the C++ has
//   it float SmoothVisibility(Receiver receiver, vec2 uv)     between the four nearest texel
//   centres
//   int Coverage(Receiver receiver, vec2 uv)                3: that texel lies on the receiver; 2: one
//   of the four does; 1: one within about 12 texels; 0: none
std::string VisibilityGlsl(int counts_binding);

}  // namespace penumbra
