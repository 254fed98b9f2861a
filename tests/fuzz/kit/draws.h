// Random choices from a seed: the same seed, the same choices, with any compiler.
//
//   Draws draws(seed);
//   if (draws.OneIn(4)) bytes.resize(draws.Below(bytes.size()));
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>

namespace penumbra::fuzzing {

class Draws {
 public:
  explicit Draws(uint64_t seed) : state_(seed) {}

  // SplitMix64 (Steele, Lea and Flood 2014): one word of state, which a seed fills at no cost.
  uint64_t Bits() {
    uint64_t bits = state_ += 0x9e3779b97f4a7c15;
    bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9;
    bits = (bits ^ (bits >> 27)) * 0x94d049bb133111eb;
    return bits ^ (bits >> 31);
  }
  // In [0, n); 0 where n is 0.
  uint64_t Below(uint64_t n) { return n == 0 ? 0 : Bits() % n; }
  bool OneIn(uint64_t n) { return Below(n) == 0; }
  template <typename List>
  const auto& OneOf(const List& list) {
    return list[static_cast<size_t>(Below(std::size(list)))];
  }

 private:
  uint64_t state_;
};

}  // namespace penumbra::fuzzing
