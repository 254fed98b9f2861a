#include "render/technique/shadow_volume/edge_kernel.h"

#include <cstddef>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/technique/shadow_volume/edge_kernel.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each target
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 16>;
using VF = hn::Vec<F>;

HWY_INLINE uint64_t Bits(hn::Mask<F> mask) {
  uint8_t bytes[8] = {};
  hn::StoreMaskBits(F(), mask, bytes);
  uint64_t bits;
  std::memcpy(&bits, bytes, sizeof(bits));
  return bits;
}

// Bits of the samples that differ, by more than either limit.
struct Differing {
  uint64_t low, high;
};

template <bool kFromInfinity>
HWY_INLINE Differing Compare(VF a, VF b, const EdgeLimits& limits) {
  const F f;
  const VF difference = hn::Abs(hn::Sub(a, b));
  VF low = hn::Set(f, limits.low), high = hn::Set(f, limits.high);
  if constexpr (!kFromInfinity) {
    const VF most = hn::Max(a, b);
    low = hn::Mul(low, most);
    high = hn::Mul(high, most);
  }
  const auto is_low = hn::Gt(difference, low);
  if (hn::AllFalse(f, is_low)) return {0, 0};
  return {Bits(is_low), Bits(hn::Gt(difference, high))};
}

template <bool kFromInfinity>
HWY_INLINE void MarkRow(const float* row, const float* next_row, uint32_t words,
                        const EdgeLimits& limits, const EdgeWords& marks) {
  const F f;
  const size_t lanes = hn::Lanes(f);
  for (uint32_t word = 0; word < words; ++word) {
    Differing right{0, 0}, next{0, 0};
    for (size_t k = 0; k < 64; k += lanes) {
      const size_t x = size_t{64} * word + k;
      const VF here = hn::LoadU(f, row + x);
      const Differing r = Compare<kFromInfinity>(here, hn::LoadU(f, row + x + 1), limits);
      const Differing n = Compare<kFromInfinity>(here, hn::LoadU(f, next_row + x), limits);
      right = {right.low | r.low << k, right.high | r.high << k};
      next = {next.low | n.low << k, next.high | n.high << k};
    }
    marks.right_low[word] = right.low;
    marks.right_high[word] = right.high;
    marks.next_low[word] = next.low;
    marks.next_high[word] = next.high;
  }
}

void MarkDifferences(const float* row, const float* next_row, uint32_t words,
                     const EdgeLimits& limits, const EdgeWords& marks) {
  if (limits.from_infinity) {
    MarkRow<true>(row, next_row, words, limits, marks);
  } else {
    MarkRow<false>(row, next_row, words, limits, marks);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace penumbra {

HWY_EXPORT(MarkDifferences);

void MarkDifferences(const float* row, const float* next_row, uint32_t words,
                     const EdgeLimits& limits, const EdgeWords& marks) {
  HWY_DYNAMIC_DISPATCH(MarkDifferences)(row, next_row, words, limits, marks);
}

}  // namespace penumbra
#endif  // HWY_ONCE
