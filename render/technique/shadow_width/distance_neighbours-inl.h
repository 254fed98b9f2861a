// Distances of texels that are not deep in shadow, from their neighbours in the row; compiled once
// for each instruction set.

#if defined(PENUMBRA_DISTANCE_NEIGHBOURS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PENUMBRA_DISTANCE_NEIGHBOURS_INL_H_
#undef PENUMBRA_DISTANCE_NEIGHBOURS_INL_H_
#else
#define PENUMBRA_DISTANCE_NEIGHBOURS_INL_H_
#endif

#include "hwy/highway.h"
#include "render/technique/shadow_width/distance_blocks-inl.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

// Squares of a row's distances along columns.
class NeighbourSquares {
 public:
  HWY_INLINE explicit NeighbourSquares(uint32_t width)
      : width_(width),
        filled_(size_t{BlockCount(width)} * BlockSize()),
        squares_(std::make_unique_for_overwrite<uint16_t[]>(filled_ + 2 * kNarrow)) {
    constexpr auto kFarSquare = static_cast<uint16_t>(kFarColumn * kFarColumn);
    std::fill_n(squares_.get(), kNarrow, kFarSquare);
    std::fill_n(squares_.get() + kNarrow + filled_, kNarrow, kFarSquare);
  }

  // `columns`  filled up with kNoneLit to whole blocks
  HWY_INLINE void Set(const int16_t* columns) {
    const I16 d;
    const VI16 far_away = hn::Set(d, kFarColumn);
    for (size_t x = 0; x < filled_; x += hn::Lanes(d)) {
      const auto column = hn::BitCast(U16(), hn::Min(hn::LoadU(d, columns + x), far_away));
      hn::StoreU(hn::Mul(column, column), U16(), squares_.get() + kNarrow + x);
    }
  }

  // Whether the block at `x` has no distance above kNarrow + 1. If so, they are stored.
  HWY_INLINE bool Measure(size_t x, float* distances) const {
    const U16 d;
    const uint16_t* here = squares_.get() + kNarrow + x;
    VU16 least = hn::LoadU(d, here);
    const size_t left = width_ - x;
    if (left < hn::Lanes(d)) least = hn::IfThenElseZero(hn::FirstN(d, left), least);
    if (left >= hn::Lanes(d) && hn::AllTrue(d, hn::Eq(least, hn::Zero(d)))) {  // roots take long
      std::fill_n(distances + x, hn::Lanes(d), 0.0f);
      return true;
    }
    const auto is_settled = [&](int k) HWY_ATTR {  // by the neighbours less than k away
      const VU16 square = hn::Set(d, static_cast<uint16_t>(k * k));
      return hn::AllTrue(d, hn::Eq(hn::Min(least, square), least));
    };
    const auto look = [&](int k) HWY_ATTR {
      const VU16 square = hn::Set(d, static_cast<uint16_t>(k * k));
      const VU16 lesser = hn::Min(hn::LoadU(d, here - k), hn::LoadU(d, here + k));
      least = hn::Min(least, hn::SaturatedAdd(lesser, square));
    };
    int k = 1;
    for (; k < kNarrow && !is_settled(k); k += 2) {
      look(k);
      look(k + 1);
    }
    if (k > kNarrow && !is_settled(k)) return false;
    const I32 wider;
    StoreRoots(hn::PromoteTo(wider, hn::LowerHalf(least)),
               hn::PromoteTo(wider, hn::UpperHalf(hn::Half<U16>(), least)), distances + x, left);
    return true;
  }

 private:
  // Distances along columns are cut off here, so that squares fit 16 bits; far beyond kNarrow.
  static constexpr int16_t kFarColumn = 255;

  const uint32_t width_;
  const size_t filled_;
  const std::unique_ptr<uint16_t[]> squares_;  // with kNarrow more at either end
};

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#endif  // toggled for each target
