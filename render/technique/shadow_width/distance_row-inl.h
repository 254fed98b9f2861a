// From distances along columns to distances in the plane, a row at a time; compiled once for each
// instruction set.
//
//   d(x)² = min_j (x − j)² + c(j)²
//
// A row is cut into blocks. Where shadows are narrow, a block looks at its neighbours at distances
// k = 1, 2, … until k² is no less than any square found (distance_neighbours-inl.h). Where they are
// wide, it looks at the columns from its first texel's nearest one to that of the next block's
// first texel (distance_nearest-inl.h), which are one a texel on average however wide shadows are.
// Both find the same. A texel's distance differs by at most 1 from the one below it, so what a
// block was in one row it is most likely in the next.

#if defined(PENUMBRA_DISTANCE_ROW_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PENUMBRA_DISTANCE_ROW_INL_H_
#undef PENUMBRA_DISTANCE_ROW_INL_H_
#else
#define PENUMBRA_DISTANCE_ROW_INL_H_
#endif

#include "hwy/highway.h"
#include "render/technique/shadow_width/distance_columns-inl.h"
#include "render/technique/shadow_width/distance_nearest-inl.h"
#include "render/technique/shadow_width/distance_neighbours-inl.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

class DistanceRow {
 public:
  HWY_INLINE explicit DistanceRow(uint32_t width)
      : width_(width),
        is_wide_(std::make_unique<bool[]>(BlockCount(width))),
        squares_(width),
        lit_(width),
        nearest_(width) {}

  // `columns`  filled up with kNoneLit to whole blocks
  HWY_INLINE void Measure(const int16_t* columns, float* distances) {
    squares_.Set(columns);
    uint32_t wide = 0;  // blocks before this one that are wide and wait for the next ones
    bool has_lit = false;
    const auto measure_wide = [&](uint32_t end) HWY_ATTR {
      if (wide == 0) return;
      if (!has_lit) lit_.Set(columns);
      has_lit = true;
      MeasureWide(columns, end - wide, end, distances);
      wide = 0;
    };
    const uint32_t blocks = BlockCount(width_);
    for (uint32_t b = 0; b < blocks; ++b) {
      is_wide_[b] = is_wide_[b] || !squares_.Measure(size_t{b} * BlockSize(), distances);
      if (is_wide_[b]) {
        ++wide;
      } else {
        measure_wide(b);
      }
    }
    measure_wide(blocks);
  }

 private:
  // Blocks [first, end).
  HWY_INLINE void MeasureWide(const int16_t* columns, uint32_t first, uint32_t end,
                              float* distances) {
    const I32 d;
    nearest_.Find(lit_, columns, first, end);
    const VI32 narrow = hn::Set(d, kNarrow * kNarrow);
    for (uint32_t b = first; b < end; ++b) {
      const size_t x = size_t{b} * BlockSize();
      const VI32 low_x = Count(static_cast<int32_t>(x));
      const VI32 high_x = Count(static_cast<int32_t>(x + hn::Lanes(d)));
      VI32 low = hn::Set(d, std::numeric_limits<int32_t>::max()), high = low;
      for (int32_t place = nearest_[b - first]; place <= nearest_[b - first + 1]; ++place) {
        low = hn::Min(low, lit_.Squares(low_x, place));
        high = hn::Min(high, lit_.Squares(high_x, place));
      }
      StoreRoots(low, high, distances + x, width_ - x);
      is_wide_[b] = !hn::AllFalse(d, hn::Gt(hn::Max(low, high), narrow));
    }
  }

  const uint32_t width_;
  const std::unique_ptr<bool[]> is_wide_;  // each block, as far as the last row tells
  NeighbourSquares squares_;
  LitColumns lit_;
  NearestColumns nearest_;
};

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#endif  // toggled for each target
