// Random numbers that are a function of what they are for: no state, so the same seed gives the
// same bits whatever the order or the number of threads.
#pragma once

#include <cstdint>

namespace penumbra {

// A 64-bit finaliser with full avalanche.
// Source  Steele, Lea and Flood 2014, SplitMix64; the variant by Stafford ("Mix13").
constexpr uint64_t MixBits(uint64_t v) {
  v += 0x9e3779b97f4a7c15ull;
  v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9ull;
  v = (v ^ (v >> 27)) * 0x94d049bb133111ebull;
  return v ^ (v >> 31);
}

// The number in [0, 1) at (`index`, `dimension`) of the stream that `seed` names.
constexpr double UniformAt(uint64_t seed, uint64_t index, uint64_t dimension) {
  const uint64_t bits = MixBits(MixBits(MixBits(seed) ^ index) ^ (dimension + 1));
  return static_cast<double>(bits >> 11) * 0x1.0p-53;
}

}  // namespace penumbra
