#include "render/technique/soft_texture/bit_counters.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/technique/soft_texture/bit_counters.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each target
#include "hwy/highway.h"
#include "render/technique/soft_texture/coverage_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using U = hn::CappedTag<uint32_t, kMaxLanes>;
using VU = hn::Vec<U>;

void AddAndClear(ShadowBitmap& bitmap, std::span<std::vector<uint32_t>> planes) {
  const U u;
  const uint32_t rows = bitmap.stride - ShadowBitmap::kRowPadding;
  for (uint32_t c = 0; c < bitmap.columns; ++c) {
    uint32_t* words = bitmap.Column(c);
    const size_t offset = size_t{c} * bitmap.stride;
    for (uint32_t row = bitmap.touched_rows_begin[c]; row < bitmap.touched_rows_end[c];
         row += hn::Lanes(u)) {
      VU carry = hn::LoadU(u, words + row);
      hn::StoreU(hn::Zero(u), u, words + row);
      for (std::vector<uint32_t>& plane : planes) {
        if (hn::AllTrue(u, hn::Eq(carry, hn::Zero(u)))) break;
        uint32_t* sum = plane.data() + offset + row;
        const VU old = hn::LoadU(u, sum);
        hn::StoreU(hn::Xor(old, carry), u, sum);
        carry = hn::And(old, carry);
      }
    }
    bitmap.touched_rows_begin[c] = rows;
    bitmap.touched_rows_end[c] = 0;
  }
}

void AddRowCounts(std::span<const std::vector<uint32_t>> planes, uint32_t stride, uint32_t row,
                  uint32_t width, uint16_t* counts) {
  const U u;
  const hn::Rebind<uint16_t, U> u16;
  const VU one = hn::Set(u, 1);
  for (uint32_t column = 0; 32 * column < width; ++column) {
    const size_t word = size_t{column} * stride + row;
    uint32_t any = 0;
    for (const auto& plane : planes) any |= plane[word];
    if (any == 0) continue;
    HWY_ALIGN uint16_t texels[32];
    for (uint32_t bit = 0; bit < 32; bit += hn::Lanes(u)) {
      const VU shift = hn::Iota(u, bit);
      VU sum = hn::Zero(u);
      uint32_t weight = 0;
      for (const auto& plane : planes) {
        const VU bits = hn::And(hn::Shr(hn::Set(u, plane[word]), shift), one);
        sum = hn::Or(sum, hn::ShiftLeftSame(bits, static_cast<int>(weight++)));
      }
      hn::StoreU(hn::DemoteTo(u16, hn::BitCast(hn::RebindToSigned<U>(), sum)), u16, texels + bit);
    }
    const uint32_t in_row = width - 32 * column < 32 ? width - 32 * column : 32;
    for (uint32_t k = 0; k < in_row; ++k) {
      counts[32 * column + k] = static_cast<uint16_t>(counts[32 * column + k] + texels[k]);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace penumbra {

HWY_EXPORT(AddAndClear);
HWY_EXPORT(AddRowCounts);

void AddAndClear(ShadowBitmap& bitmap, std::span<std::vector<uint32_t>> planes) {
  HWY_DYNAMIC_DISPATCH(AddAndClear)(bitmap, planes);
}

void AddRowCounts(std::span<const std::vector<uint32_t>> planes, uint32_t stride, uint32_t row,
                  uint32_t width, uint16_t* counts) {
  HWY_DYNAMIC_DISPATCH(AddRowCounts)(planes, stride, row, width, counts);
}

}  // namespace penumbra
#endif  // HWY_ONCE
