// What the drawing kernels share, compiled once for each instruction set.

#if defined(PENUMBRA_KERNEL_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PENUMBRA_KERNEL_ROWS_INL_H_
#undef PENUMBRA_KERNEL_ROWS_INL_H_
#else
#define PENUMBRA_KERNEL_ROWS_INL_H_
#endif

#include <cstdint>
#include <vector>

#include "hwy/highway.h"
#include "render/technique/soft_texture/coverage_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, kMaxLanes>;
using I = hn::RebindToSigned<F>;
using U = hn::RebindToUnsigned<F>;
using VF = hn::Vec<F>;
using VI = hn::Vec<I>;
using VU = hn::Vec<U>;

// The next whole number at or above `x`, for |x| < 2²²: adding 1.5 · 2²³ leaves the number in the
// lowest bits of the mantissa. Highway's own conversion spends four more instructions on larger
// numbers.
HWY_INLINE VI CeilToInt(VF x) {
  const F f;
  const I i;
  const VF magic = hn::Set(f, 12582912.0f);
  return hn::Sub(hn::BitCast(i, hn::Add(hn::Ceil(x), magic)), hn::BitCast(i, magic));
}

struct Corners {
  VF x, y;
};

// Offsets from the receiver's origin to texels. Whoever projects a vertex gets the same bits.
struct Projected {
  Corners texel;
  VF w;
};

HWY_INLINE Projected Project(VF vx, VF vy, VF vz, const TexelProjection& p) {
  const F f;
  const VF half = hn::Set(f, 0.5f), one = hn::Set(f, 1.0f), zero = hn::Zero(f);
  const auto row = [&](const float(&r)[3], VF constant) HWY_ATTR {
    return hn::MulAdd(vx, hn::Set(f, r[0]),
                      hn::MulAdd(vy, hn::Set(f, r[1]), hn::MulAdd(vz, hn::Set(f, r[2]), constant)));
  };
  const VF w = row(p.w_row, one);
  const VF inverse_w = hn::Div(one, w);
  return {{hn::MulSub(row(p.x_row, zero), inverse_w, half),
           hn::MulSub(row(p.y_row, zero), inverse_w, half)},
          w};
}

HWY_INLINE void SortByRow(Corners& a, Corners& b) {
  const auto swap = hn::Gt(a.y, b.y);
  const VF ax = a.x, ay = a.y;
  a = {hn::IfThenElse(swap, b.x, ax), hn::IfThenElse(swap, b.y, ay)};
  b = {hn::IfThenElse(swap, ax, b.x), hn::IfThenElse(swap, ay, b.y)};
}

// The number with its lowest k bits set; 32 or more gives all.
HWY_INLINE VU LowBits(VI k) {
  const U u;
  const VU bits = hn::BitCast(u, k);
  const VU shifted = hn::Shl(hn::Set(u, 1), hn::And(bits, hn::Set(u, 31)));
  const VU top = hn::IfThenElseZero(hn::Lt(bits, hn::Set(u, 32)), shifted);
  return hn::Sub(top, hn::Set(u, 1));
}

HWY_INLINE VF SlopeBetween(const Corners& low, const Corners& high) {
  return hn::Div(hn::Sub(high.x, low.x), hn::Sub(high.y, low.y));
}

// Lanes as bits of a number.
template <class M>
HWY_INLINE uint32_t Bits(M mask) {
  uint8_t bytes[8] = {};
  hn::StoreMaskBits(F(), mask, bytes);
  return bytes[0] | uint32_t{bytes[1]} << 8;
}

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#endif  // toggled for each target
