// Blocks of texels and their squared distances in vectors, compiled once for each instruction set
// that has vectors of 16-bit numbers.

#if defined(PENUMBRA_DISTANCE_BLOCKS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PENUMBRA_DISTANCE_BLOCKS_INL_H_
#undef PENUMBRA_DISTANCE_BLOCKS_INL_H_
#else
#define PENUMBRA_DISTANCE_BLOCKS_INL_H_
#endif

#include "hwy/highway.h"
#include "render/technique/shadow_width/distance_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

using U16 = hn::RebindToUnsigned<I16>;
using I32 = hn::Repartition<int32_t, I16>;  // half a block
using F32 = hn::RebindToFloat<I32>;
using VU16 = hn::Vec<U16>;
using VI32 = hn::Vec<I32>;

// As far as neighbours are looked at one by one, in texels; see distance_row-inl.h. With 8, 12, 16,
// 24, 32 and 48, a mask of 512² took 0.46, 0.37, 0.36, 0.34, 0.38 and 0.36 ms where disks of up
// to 12 texels block, and 0.46, 0.48, 0.53, 0.58, 0.69 and 0.84 ms where all but 64 texels do.
inline constexpr int kNarrow = 16;

// x, x + 1, … (hn::Iota(d, x) goes through memory, number by number).
HWY_INLINE VI32 Count(int32_t x) {
  const I32 d;
  return hn::Add(hn::Iota(d, 0), hn::Set(d, x));
}

// Roots of a block's squares, of which the first `count` are stored.
HWY_INLINE void StoreRoots(VI32 low, VI32 high, float* to, size_t count) {
  const F32 f;
  const size_t half = hn::Lanes(f);
  const auto low_root = hn::Sqrt(hn::ConvertTo(f, low));
  const auto high_root = hn::Sqrt(hn::ConvertTo(f, high));
  if (count >= 2 * half) {
    hn::StoreU(low_root, f, to);
    hn::StoreU(high_root, f, to + half);
    return;
  }
  HWY_ALIGN float part[kBlockMost];
  hn::StoreU(low_root, f, part);
  hn::StoreU(high_root, f, part + half);
  std::copy_n(part, count, to);
}

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#endif  // toggled for each target
