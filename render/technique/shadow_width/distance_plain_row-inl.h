// What distance_row-inl.h does, texel by texel, for processors without the vectors that it needs.

#if defined(PENUMBRA_DISTANCE_PLAIN_ROW_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PENUMBRA_DISTANCE_PLAIN_ROW_INL_H_
#undef PENUMBRA_DISTANCE_PLAIN_ROW_INL_H_
#else
#define PENUMBRA_DISTANCE_PLAIN_ROW_INL_H_
#endif

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

class DistanceRow {
 public:
  explicit DistanceRow(uint32_t width) : width_(static_cast<int32_t>(width)) {}

  // Looks at the neighbours k away for k = 1, 2, … until k² is no less than the square found.
  void Measure(const int16_t* columns, float* distances) {
    for (int32_t x = 0; x < width_; ++x) {
      const auto square = [&](int32_t j) { return (x - j) * (x - j) + columns[j] * columns[j]; };
      int32_t least = square(x);
      for (int32_t k = 1; k < width_ && k * k < least; ++k) {
        if (x >= k) least = std::min(least, square(x - k));
        if (x + k < width_) least = std::min(least, square(x + k));
      }
      distances[x] = std::sqrt(static_cast<float>(least));
    }
  }

 private:
  const int32_t width_;
};

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#endif  // toggled for each target
