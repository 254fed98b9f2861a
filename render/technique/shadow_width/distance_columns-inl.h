// Squared distances from texels of a row to lit texels of its columns, compiled once for each
// instruction set.

#if defined(PENUMBRA_DISTANCE_COLUMNS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PENUMBRA_DISTANCE_COLUMNS_INL_H_
#undef PENUMBRA_DISTANCE_COLUMNS_INL_H_
#else
#define PENUMBRA_DISTANCE_COLUMNS_INL_H_
#endif

#include <limits>

#include "hwy/highway.h"
#include "render/technique/shadow_width/distance_blocks-inl.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

// A row's columns j that have a lit texel, c away, as pairs of 16-bit numbers (j, −c): they differ
// from (x, 0) by (x − j, c), and one instruction multiplies both halves of that with themselves and
// adds the products. Columns are named by their place in the list.
class LitColumns {
 public:
  HWY_INLINE explicit LitColumns(uint32_t width)
      : vectors_(static_cast<uint32_t>(size_t{BlockCount(width)} * BlockSize() / hn::Lanes(I32()))),
        pairs_(std::make_unique_for_overwrite<int32_t[]>((vectors_ + 1) * hn::Lanes(I32()))),
        before_(std::make_unique_for_overwrite<int32_t[]>(vectors_ + 1)) {}

  // `columns`  filled up with kNoneLit to whole blocks
  HWY_INLINE void Set(const int16_t* columns) {
    const I32 d;
    const hn::Rebind<int16_t, I32> d16;
    const VI32 none = hn::Set(d, int32_t{kNoneLit});
    int32_t count = 0;
    for (uint32_t v = 0; v < vectors_; ++v) {
      before_[v] = count;
      const int32_t x = static_cast<int32_t>(v) * Lanes();
      const VI32 column = hn::PromoteTo(d, hn::LoadU(d16, columns + x));
      const auto has_none = hn::Eq(column, none);
      if (hn::AllTrue(d, has_none)) continue;
      hn::StoreU(hn::Or(hn::ShiftLeft<16>(hn::Neg(column)), Count(x)), d, pairs_.get() + count);
      count = hn::AllFalse(d, has_none) ? count + Lanes() : KeepLit(columns + x, count);
    }
    before_[vectors_] = count;
    hn::StoreU(hn::ShiftLeft<16>(hn::Neg(none)), d, pairs_.get() + count);  // no nearer than any
  }

  HWY_INLINE int32_t size() const { return before_[vectors_]; }

  // The first column that lies at `x` or a few before, and the last one at `x` or a few after.
  HWY_INLINE int32_t FirstFrom(int32_t x) const { return before_[std::max(x, 0) / Lanes()]; }
  HWY_INLINE int32_t LastTo(int32_t x) const {
    const int32_t end = static_cast<int32_t>(vectors_);
    return before_[std::min(x / Lanes() + 1, end)] - 1;
  }

  // Squared distances of as many `x` as there are lanes to column `place`.
  HWY_INLINE VI32 Squares(VI32 x, int32_t place) const {
    return Squares(x, hn::Set(I32(), pairs_[place]));
  }

  // The column of [first, last] that is nearest to `x`; the ones after it may be seen too.
  HWY_INLINE int32_t Nearest(int32_t x, int32_t first, int32_t last) const {
    if (first == last) return first;
    const I32 d;
    const VI32 here = hn::Set(d, x);
    VI32 least = hn::Set(d, std::numeric_limits<int32_t>::max());
    VI32 least_at = hn::Zero(d);
    for (int32_t place = first; place <= last; place += Lanes()) {
      const VI32 square = Squares(here, hn::LoadU(d, pairs_.get() + place));
      const auto is_less = hn::Lt(square, least);
      least = hn::Min(square, least);
      least_at = hn::IfThenElse(is_less, hn::Set(d, place), least_at);
    }
    const auto is_least = hn::Eq(least, hn::MinOfLanes(d, least));
    const auto lane = hn::FindFirstTrue(d, is_least);
    HWY_ALIGN int32_t places[kBlockMost];
    hn::Store(least_at, d, places);
    return places[lane] + static_cast<int32_t>(lane);
  }

 private:
  // Closes up the pairs of a vector, the first at `count`, and returns where they end.
  // (hn::CompressStore copies its table of 1 KB to the stack each time.)
  HWY_INLINE int32_t KeepLit(const int16_t* columns, int32_t count) {
    int32_t* pairs = pairs_.get() + count;
    for (int32_t lane = 0; lane < Lanes(); ++lane) {
      pairs_[count] = pairs[lane];
      count += columns[lane] != kNoneLit;
    }
    return count;
  }

  HWY_INLINE static int32_t Lanes() { return static_cast<int32_t>(hn::Lanes(I32())); }

  HWY_INLINE static VI32 Squares(VI32 x, VI32 pair) {
    const I32 d;
    const VI16 apart = hn::Sub(hn::BitCast(I16(), x), hn::BitCast(I16(), pair));
    VI32 more = hn::Zero(d);
    const VI32 some = hn::ReorderWidenMulAccumulate(d, apart, apart, hn::Zero(d), more);
    return hn::RearrangeToOddPlusEven(some, more);
  }

  const uint32_t vectors_;  // that the row's columns fill
  const std::unique_ptr<int32_t[]> pairs_;
  const std::unique_ptr<int32_t[]> before_;  // each vector: how many columns are listed
};

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#endif  // toggled for each target
