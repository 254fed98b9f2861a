// IEEE 754 numbers of 16 bits.
//
//   uint16_t bits = HalfFromFloat(0.1f);   // to the nearest, ties to even
//   float back = FloatFromHalf(bits);      // without loss
#pragma once

#include <bit>
#include <cstdint>

namespace penumbra {

inline constexpr float kLargestHalf = 65504.0f;

// From 65,520 on infinity; NaN stays NaN.
constexpr uint16_t HalfFromFloat(float x) {
  const auto bits = std::bit_cast<uint32_t>(x);
  const auto sign = static_cast<uint16_t>((bits >> 16) & 0x8000u);
  const uint32_t magnitude = bits & 0x7fffffffu;
  uint32_t half = 0;
  if (magnitude > 0x7f800000u) {
    half = 0x7e00u;
  } else if (magnitude >= 0x47800000u) {  // 2¹⁶
    half = 0x7c00u;
  } else if (magnitude < 0x38800000u) {  // 2⁻¹⁴: what has fewer digits
    // ½ has its last digit at 2⁻²⁴, where that of the smallest half is.
    const float shifted = std::bit_cast<float>(magnitude) + 0.5f;
    half = std::bit_cast<uint32_t>(shifted) - 0x3f000000u;
  } else {
    const uint32_t rounded = magnitude + 0xfffu + ((magnitude >> 13) & 1u);
    half = (rounded - 0x38000000u) >> 13;  // the exponent's bias goes from 127 to 15
  }
  return static_cast<uint16_t>(sign | half);
}

constexpr float FloatFromHalf(uint16_t half) {
  const uint32_t sign = uint32_t{half & 0x8000u} << 16;
  const uint32_t magnitude = half & 0x7fffu;
  if (magnitude < 0x400u) {
    const float value = static_cast<float>(magnitude) * 0x1p-24f;
    return std::bit_cast<float>(std::bit_cast<uint32_t>(value) | sign);
  }
  const uint32_t bias = magnitude < 0x7c00u ? 0x38000000u : 0x70000000u;
  return std::bit_cast<float>(sign | ((magnitude << 13) + bias));
}

}  // namespace penumbra
