#include "render/technique/soft_texture/bit_counters.h"

#include <algorithm>
#include <cstdint>

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

// Adds the counts of `count` ≤ Lanes texels, of which `bits` has one plane's each.
template <class D>
HWY_INLINE void AddCounts(D u16, const uint16_t* bits, size_t planes, size_t count,
                          uint16_t* counts) {
  HWY_ALIGN static constexpr uint16_t kPlaces[16] = {
      1u << 0, 1u << 1, 1u << 2,  1u << 3,  1u << 4,  1u << 5,  1u << 6,  1u << 7,
      1u << 8, 1u << 9, 1u << 10, 1u << 11, 1u << 12, 1u << 13, 1u << 14, 1u << 15};
  const auto place = hn::Load(u16, kPlaces);
  auto sum = hn::Zero(u16);
  for (size_t p = 0; p < planes; ++p) {
    const auto is_set = hn::TestBit(hn::Set(u16, bits[p]), place);
    const auto weight = hn::Set(u16, static_cast<uint16_t>(1u << p));
    sum = hn::Add(sum, hn::IfThenElseZero(is_set, weight));
  }
  if (count == hn::Lanes(u16)) {
    hn::StoreU(hn::Add(sum, hn::LoadU(u16, counts)), u16, counts);
    return;
  }
  HWY_ALIGN uint16_t texels[16];
  hn::Store(sum, u16, texels);
  for (size_t k = 0; k < count; ++k) counts[k] = static_cast<uint16_t>(counts[k] + texels[k]);
}

void AddRowCounts(std::span<const std::vector<uint32_t>> planes, uint32_t stride, uint32_t row,
                  uint32_t width, uint16_t* counts) {
  const hn::CappedTag<uint16_t, 16> u16;
  const auto lanes = static_cast<uint32_t>(hn::Lanes(u16));
  for (uint32_t column = 0; 32 * column < width; ++column) {
    const size_t word = size_t{column} * stride + row;
    uint32_t any = 0;
    for (const auto& plane : planes) any |= plane[word];
    if (any == 0) continue;
    const uint32_t end = std::min(32 * column + 32, width);
    for (uint32_t texel = 32 * column; texel < end; texel += lanes) {
      uint16_t bits[16];
      const uint32_t shift = texel % 32;
      for (size_t p = 0; p < planes.size(); ++p) {
        bits[p] = static_cast<uint16_t>(planes[p][word] >> shift);
      }
      AddCounts(u16, bits, planes.size(), std::min(lanes, end - texel), counts + texel);
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
