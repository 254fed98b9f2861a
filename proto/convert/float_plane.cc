#include "proto/convert/float_plane.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace penumbra {

void ToPlane(std::span<const float> floats, std::vector<char>& plane) {
  plane.resize(floats.size() * 4);
  uint32_t before = 0;
  for (size_t i = 0; i < floats.size(); ++i) {
    const auto bits = std::bit_cast<uint32_t>(floats[i]);
    const uint32_t difference = bits - std::exchange(before, bits);
    for (size_t k = 0; k < 4; ++k) {
      plane[k * floats.size() + i] = static_cast<char>(difference >> (8 * k));
    }
  }
}

void FromPlane(std::span<const char> plane, std::vector<float>& floats) {
  const size_t count = plane.size() / 4;
  floats.resize(count);
  uint32_t bits = 0;
  for (size_t i = 0; i < count; ++i) {
    for (size_t k = 0; k < 4; ++k) {
      bits += uint32_t{static_cast<uint8_t>(plane[k * count + i])} << (8 * k);
    }
    floats[i] = std::bit_cast<float>(bits);
  }
}

}  // namespace penumbra
