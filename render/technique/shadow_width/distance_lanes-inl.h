// Rows of distances in vectors, compiled once for each instruction set.

#if defined(PENUMBRA_DISTANCE_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PENUMBRA_DISTANCE_LANES_INL_H_
#undef PENUMBRA_DISTANCE_LANES_INL_H_
#else
#define PENUMBRA_DISTANCE_LANES_INL_H_
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "hwy/highway.h"
#include "render/technique/shadow_width/distance_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// The most texels of a block: what a vector of 16-bit numbers holds.
inline constexpr size_t kBlockMost = 16;

using I16 = hn::CappedTag<int16_t, kBlockMost>;
using VI16 = hn::Vec<I16>;

HWY_INLINE uint32_t BlockSize() { return static_cast<uint32_t>(hn::Lanes(I16())); }

HWY_INLINE uint32_t BlockCount(uint32_t width) { return (width + BlockSize() - 1) / BlockSize(); }

// Distances along columns, for each texel of a strip; rows are filled up to whole blocks.
class ColumnDistances {
 public:
  HWY_INLINE ColumnDistances(uint32_t width, uint32_t rows)
      : stride_(size_t{BlockCount(width)} * BlockSize()),
        values_(std::make_unique_for_overwrite<int16_t[]>(stride_ * rows)) {}
  HWY_INLINE int16_t* Row(uint32_t y) { return values_.get() + stride_ * y; }

 private:
  const size_t stride_;
  const std::unique_ptr<int16_t[]> values_;
};

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#endif  // toggled for each target
