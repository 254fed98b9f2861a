// How exactly a radiance texture holds its numbers, in memory and on the wire.
//
//   const RadianceCodec codec(RadianceFormat::kUnorm8, scale);
//   float kept = codec.Decode(codec.Encode(radiance));
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "render/math/half.h"

namespace penumbra {

enum class RadianceFormat : uint8_t {
  kFloat32,  // without loss
  kHalf,     // 16-bit floats, at most 65,504
  kUnorm16,  // whole multiples of scale / 65,535, at most scale
  kUnorm8,   // whole multiples of scale / 255, at most scale
};

// In the order of the formats.
inline constexpr std::array<std::string_view, 4> kRadianceFormatNames = {"float32", "half",
                                                                         "unorm16", "unorm8"};

inline std::optional<RadianceFormat> RadianceFormatNamed(std::string_view name) {
  for (size_t i = 0; i < kRadianceFormatNames.size(); ++i) {
    if (kRadianceFormatNames[i] == name) return static_cast<RadianceFormat>(i);
  }
  return std::nullopt;
}

constexpr size_t BytesPerChannel(RadianceFormat format) {
  return format == RadianceFormat::kFloat32 ? 4 : format == RadianceFormat::kUnorm8 ? 1 : 2;
}

constexpr bool IsUnorm(RadianceFormat format) {
  return format == RadianceFormat::kUnorm16 || format == RadianceFormat::kUnorm8;
}

// Between a number and its code of 8 or 16 bits, to the nearest. Codes survive a round trip.
//
// Error  kHalf: 2⁻¹¹ of the number or 2⁻²⁵; kUnorm16: scale / 131,070; kUnorm8: scale / 510; each
//        and 2⁻²³ of the number for single precision
class RadianceCodec {
 public:
  // format  not kFloat32, which needs no code
  // scale   > 0; of kUnorm16 and kUnorm8 alone
  RadianceCodec(RadianceFormat format, float scale)
      : is_half_(format == RadianceFormat::kHalf),
        steps_(format == RadianceFormat::kUnorm8 ? 255.0 : 65535.0),
        scale_(scale) {}

  uint16_t Encode(float value) const {
    if (!(value > 0)) return 0;
    if (is_half_) return HalfFromFloat(std::min(value, kLargestHalf));
    return static_cast<uint16_t>(std::nearbyint(std::min(value / scale_, 1.0) * steps_));
  }
  float Decode(uint16_t code) const {
    return is_half_ ? FloatFromHalf(code) : static_cast<float>(code * scale_ / steps_);
  }

 private:
  bool is_half_;
  double steps_, scale_;
};

}  // namespace penumbra
