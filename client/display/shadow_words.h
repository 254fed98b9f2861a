// Artifacts that say of any surface how much of a light it sees, as 32-bit words for a shader: of
// layered attenuation maps all layers, of shadow-width maps all texels, of pictures what each pixel
// gets.
//
//   LightShadow shadow = …;
//   words.Append(ldi, shadow);
//   words.Append(width_map, shadow);
//   words.Append(view_shadow, shadow);
#pragma once

#include <cstdint>
#include <vector>

#include "render/artifact/attenuation_ldi.h"
#include "render/artifact/shadow_width_map.h"
#include "render/artifact/view_shadow.h"
#include "render/math/vec.h"

namespace penumbra {

// A face of a layered depth image or of a shadow-width map as a shader sees it, std430.
struct GpuLightFace {
  Vec4 origin{0};  // w: 1 where rays are parallel
  Vec4 axis_s{0};
  Vec4 axis_t{0};
  Vec4 axis_n{0};
  Vec4 window{0};  // its least slopes, and pixels a slope; with parallel rays metres
  uint32_t width = 0;
  uint32_t height = 0;
  // Where in the words what the face has begins. Of a layered depth image: offsets, depths, and
  // counts, two a word, the lower half first. Of a shadow-width map: depths and widths; those of
  // the second layer, or twice 0; the light's axes and the part of the window that the face tells
  // of, in texels: 9 and 4 floats.
  uint32_t first_words[6] = {0, 0, 0, 0, 0, 0};
};

// What there is for one light, std430; in the order of lights.
struct LightShadow {
  // A layered attenuation map.
  uint32_t first_face = 0;
  uint32_t face_count = 0;    // 0: there is none
  uint32_t sample_count = 0;  // of its counts
  float tolerance = 0.0f;
  // A shadow-width map.
  uint32_t first_width_face = 0;
  uint32_t width_face_count = 0;  // 0: there is none
  float c_scale = -1.0f;          // < 0: by the light
  float c_bias = 0.0f;
  // A picture, or a part of one.
  Mat4 pixel_from_world{1.0f};  // to (x, y, ·, w) of the part's pixels
  uint32_t width = 0;           // 0: there is none
  uint32_t height = 0;
  uint32_t first_word = 0;  // one a pixel: a float, below 0 where there is none
  uint32_t is_share = 0;    // 1: of the light that is seen; 0: of its strength that is reflected
  // Of the k-th light: the one that is drawn in the k-th place.
  uint32_t drawn_light = 0;
  uint32_t unused[3] = {0, 0, 0};
};

struct ShadowWords {
  std::vector<uint32_t> words;
  std::vector<GpuLightFace> faces;

  void Append(const AttenuationLdi& ldi, LightShadow& shadow);
  void Append(const ShadowWidthMap& map, LightShadow& shadow);
  // Of a picture; of other points nothing.
  void Append(const ViewShadow& view, LightShadow& shadow);
};

}  // namespace penumbra
