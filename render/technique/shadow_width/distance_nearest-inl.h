// The nearest columns of texels deep in shadow, compiled once for each instruction set.

#if defined(PENUMBRA_DISTANCE_NEAREST_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PENUMBRA_DISTANCE_NEAREST_INL_H_
#undef PENUMBRA_DISTANCE_NEAREST_INL_H_
#else
#define PENUMBRA_DISTANCE_NEAREST_INL_H_
#endif

#include <bit>

#include "hwy/highway.h"
#include "render/technique/shadow_width/distance_columns-inl.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

// Which lit column is nearest to each block's first texel, and to the last texel of the last one.
//
// The nearest column never goes back from one texel to the next: what x gains by a column further
// right is linear in x. So the ends bound what lies between them, and halves are halved again: each
// round looks at all columns once.
class NearestColumns {
 public:
  HWY_INLINE explicit NearestColumns(uint32_t width)
      : width_(static_cast<int32_t>(width)),
        nearest_(std::make_unique_for_overwrite<int32_t[]>(BlockCount(width) + 1)) {}

  // Of blocks [first, end), counted from 0 here: places in `lit`.
  HWY_INLINE int32_t operator[](size_t block) const { return nearest_[block]; }

  // The blocks beside them, if there are any, must be narrow.
  //
  // `columns`  that `lit` is made from
  HWY_INLINE void Find(const LitColumns& lit, const int16_t* columns, uint32_t first,
                       uint32_t end) {
    const uint32_t count = end - first;
    const auto size = static_cast<int32_t>(BlockSize());
    const int32_t origin = static_cast<int32_t>(first) * size;
    const int32_t last = std::min(static_cast<int32_t>(end) * size, width_) - 1;
    const auto find = [&](int32_t x, int32_t low, int32_t high, int32_t within) HWY_ATTR {
      // Columns further away than x's own lit texel are no nearer.
      const int32_t most = std::min<int32_t>(within, columns[x]);
      return lit.Nearest(x, std::max(low, lit.FirstFrom(x - most)),
                         std::min(high, lit.LastTo(x + most)));
    };
    nearest_[0] = find(origin, 0, lit.size() - 1, first > 0 ? kBesideNarrow : kNoneLit);
    nearest_[count] =
        find(last, nearest_[0], lit.size() - 1, last + 1 < width_ ? kBesideNarrow : kNoneLit);
    for (uint32_t half = std::bit_ceil(count) / 2; half > 0; half /= 2) {
      for (uint32_t i = half; i < count; i += 2 * half) {
        nearest_[i] = find(origin + static_cast<int32_t>(i) * size, nearest_[i - half],
                           nearest_[std::min(i + half, count)], kNoneLit);
      }
    }
  }

 private:
  // The most that the distance of a texel beside a narrow block is.
  static constexpr int32_t kBesideNarrow = kNarrow + 2;

  const int32_t width_;
  const std::unique_ptr<int32_t[]> nearest_;
};

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#endif  // toggled for each target
