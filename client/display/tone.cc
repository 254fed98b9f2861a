#include "client/display/tone.h"

#include <algorithm>
#include <cmath>

namespace penumbra {
namespace {

float Luminance(const Vec4& pixel) {
  return 0.2126f * pixel.x + 0.7152f * pixel.y + 0.0722f * pixel.z;
}

uint8_t Byte(float unit) { return static_cast<uint8_t>(std::lround(255.0f * unit)); }

}  // namespace

float SrgbFromLinear(float linear) {
  if (!(linear > 0.0f)) return 0.0f;
  if (linear >= 1.0f) return 1.0f;
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

std::vector<uint8_t> ToSrgb(const Picture& picture, const ToneOptions& tone) {
  std::vector<uint8_t> bytes;
  bytes.reserve(3 * picture.pixels.size());
  for (const Vec4& pixel : picture.pixels) {
    const float uncovered = 1.0f - std::clamp(pixel.w, 0.0f, 1.0f);
    for (int c = 0; c < 3; ++c) {
      bytes.push_back(
          Byte(SrgbFromLinear(tone.exposure * pixel[c] + uncovered * tone.background[c])));
    }
  }
  return bytes;
}

float SuggestExposure(const Picture& picture) {
  constexpr double kBrightShare = 0.9;  // this share of the covered pixels is darker than …
  constexpr float kShownAs = 0.6f;      // … what is shown as this, light grey
  std::vector<float> luminances;
  for (const Vec4& pixel : picture.pixels) {
    if (pixel.w > 0.5f && std::isfinite(Luminance(pixel))) luminances.push_back(Luminance(pixel));
  }
  if (luminances.empty()) return 1.0f;
  const auto nth =
      luminances.begin() + static_cast<ptrdiff_t>(kBrightShare * (luminances.size() - 1));
  std::nth_element(luminances.begin(), nth, luminances.end());
  if (*nth > 0) return kShownAs / *nth;
  const float brightest = *std::max_element(luminances.begin(), luminances.end());
  return brightest > 0 ? kShownAs / brightest : 1.0f;
}

}  // namespace penumbra
