#include "render/technique/shadow_width/distance_kernel.h"

#include <algorithm>
#include <cstring>
#include <memory>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/technique/shadow_width/distance_kernel.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each target
// Those below are compiled with it.
#include "hwy/highway.h"
#include "render/technique/shadow_width/distance_lanes-inl.h"
#if HWY_TARGET == HWY_SCALAR
#include "render/technique/shadow_width/distance_plain_row-inl.h"
#else
#include "render/technique/shadow_width/distance_row-inl.h"
#endif

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

// Of texels that are in the mask; past the row's end all are blocked.
HWY_INLINE hn::Mask<I16> IsLit(const uint8_t* row, uint32_t x, uint32_t width) {
  const I16 d;
  const hn::Rebind<uint8_t, I16> d8;
  const size_t lanes = hn::Lanes(d);
  HWY_ALIGN uint8_t end[kBlockMost];
  const uint8_t* from = row + x;
  if (x + lanes > width) {
    std::memset(end, 1, sizeof end);
    std::memcpy(end, from, width - x);
    from = end;
  }
  return hn::Eq(hn::PromoteTo(d, hn::LoadU(d8, from)), hn::Zero(d));
}

HWY_INLINE VI16 LoadPart(const int16_t* from, size_t count) {
  const I16 d;
  if (count >= hn::Lanes(d)) return hn::LoadU(d, from);
  HWY_ALIGN int16_t part[kBlockMost];
  std::fill_n(part, kBlockMost, kNoneLit);
  std::copy_n(from, count, part);
  return hn::Load(d, part);
}

HWY_INLINE void StorePart(VI16 values, int16_t* to, size_t count) {
  const I16 d;
  if (count >= hn::Lanes(d)) {
    hn::StoreU(values, d, to);
    return;
  }
  HWY_ALIGN int16_t part[kBlockMost];
  hn::Store(values, d, part);
  std::copy_n(part, count, to);
}

void FindLitEnds(const MaskStrip& strip, std::span<int16_t> first, std::span<int16_t> last) {
  const I16 d;
  const VI16 one = hn::Set(d, 1), none = hn::Set(d, kNoneLit);
  const auto step = static_cast<uint32_t>(hn::Lanes(d));
  for (uint32_t x = 0; x < strip.width; x += step) {
    VI16 from_first = none, from_last = none, row_number = hn::Zero(d);
    const uint8_t* row = strip.blocked;
    for (uint32_t y = 0; y < strip.rows; ++y, row += strip.width) {
      const auto is_lit = IsLit(row, x, strip.width);
      from_last = hn::IfThenZeroElse(is_lit, hn::SaturatedAdd(from_last, one));
      from_first = hn::Min(from_first, hn::IfThenElse(is_lit, row_number, none));
      row_number = hn::Add(row_number, one);
    }
    StorePart(from_first, first.data() + x, strip.width - x);
    StorePart(from_last, last.data() + x, strip.width - x);
  }
}

void CarryEnds(std::span<const int16_t> ends, std::span<const int16_t> beyond, uint32_t rows,
               std::span<int16_t> next) {
  const I16 d;
  const VI16 way = hn::Set(d, static_cast<int16_t>(rows));
  for (size_t x = 0; x < ends.size(); x += hn::Lanes(d)) {
    const size_t count = ends.size() - x;
    const VI16 further = hn::SaturatedAdd(LoadPart(beyond.data() + x, count), way);
    StorePart(hn::Min(LoadPart(ends.data() + x, count), further), next.data() + x, count);
  }
}

// Distances to the nearest lit texel of the column at or above each of the strip's texels.
HWY_INLINE void MeasureDown(const MaskStrip& strip, std::span<const int16_t> above,
                            ColumnDistances& columns) {
  const I16 d;
  const VI16 one = hn::Set(d, 1);
  const auto step = static_cast<uint32_t>(hn::Lanes(d));
  for (uint32_t y = 0; y < strip.rows; ++y) {
    const uint8_t* mask = strip.blocked + size_t{y} * strip.width;
    int16_t* row = columns.Row(y);
    const int16_t* before = y ? columns.Row(y - 1) : nullptr;
    for (uint32_t x = 0; x < strip.width; x += step) {
      const VI16 up =
          before ? hn::LoadU(d, before + x) : LoadPart(above.data() + x, strip.width - x);
      hn::StoreU(hn::IfThenZeroElse(IsLit(mask, x, strip.width), hn::SaturatedAdd(up, one)), d,
                 row + x);
    }
  }
}

void MeasureStrip(const MaskStrip& strip, std::span<const int16_t> above,
                  std::span<const int16_t> below, float* distances) {
  const I16 d;
  const VI16 one = hn::Set(d, 1);
  ColumnDistances columns(strip.width, strip.rows);
  MeasureDown(strip, above, columns);
  DistanceRow row_distances(strip.width);
  const auto step = static_cast<uint32_t>(hn::Lanes(d));
  for (uint32_t y = strip.rows; y-- > 0;) {
    int16_t* row = columns.Row(y);
    const int16_t* after = y + 1 < strip.rows ? columns.Row(y + 1) : nullptr;
    for (uint32_t x = 0; x < strip.width; x += step) {
      const VI16 down =
          after ? hn::LoadU(d, after + x) : LoadPart(below.data() + x, strip.width - x);
      hn::StoreU(hn::Min(hn::LoadU(d, row + x), hn::SaturatedAdd(down, one)), d, row + x);
    }
    row_distances.Measure(row, distances + size_t{y} * strip.width);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace penumbra {

HWY_EXPORT(FindLitEnds);
HWY_EXPORT(CarryEnds);
HWY_EXPORT(MeasureStrip);

void FindLitEnds(const MaskStrip& strip, std::span<int16_t> first, std::span<int16_t> last) {
  HWY_DYNAMIC_DISPATCH(FindLitEnds)(strip, first, last);
}

void CarryEnds(std::span<const int16_t> ends, std::span<const int16_t> beyond, uint32_t rows,
               std::span<int16_t> next) {
  HWY_DYNAMIC_DISPATCH(CarryEnds)(ends, beyond, rows, next);
}

void MeasureStrip(const MaskStrip& strip, std::span<const int16_t> above,
                  std::span<const int16_t> below, float* distances) {
  HWY_DYNAMIC_DISPATCH(MeasureStrip)(strip, above, below, distances);
}

}  // namespace penumbra
#endif  // HWY_ONCE
