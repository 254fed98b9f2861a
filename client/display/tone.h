// From linear light to what a screen shows.
//
//   ToneOptions tone = {.exposure = SuggestExposure(picture)};
//   std::vector<uint8_t> rgb = ToSrgb(picture, tone);
#pragma once

#include <cstdint>
#include <vector>

#include "client/display/picture.h"
#include "render/math/vec.h"

namespace penumbra {

struct ToneOptions {
  float exposure = 1.0f;                       // a radiance of 1 / exposure is white
  Vec3 background{0.0513f, 0.0561f, 0.0648f};  // linear RGB on the screen, not exposed
};

// The sRGB transfer function of a linear value, cut to [0, 1] (IEC 61966-2-1). NaN gives 0.
float SrgbFromLinear(float linear);

// H×W×3 bytes, row 0 at the top: exposed, put over the background, encoded in sRGB.
std::vector<uint8_t> ToSrgb(const Picture& picture, const ToneOptions& tone);

// The exposure that shows surfaces lit as most of the bright tenth of `picture` is as light grey; 1
// for a picture of nothing. Small glowing things do not sway it.
float SuggestExposure(const Picture& picture);

}  // namespace penumbra
