#include "render/technique/soft_texture/coverage_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/technique/soft_texture/coverage_kernel.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each target
#include "hwy/highway.h"

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

void ProjectVertices(const float* x, const float* y, const float* z, size_t count,
                     const TexelProjection& p, ProjectedVertices& out) {
  const F f;
  const VF half = hn::Set(f, 0.5f), one = hn::Set(f, 1.0f);
  const auto row = [&](const float(&r)[3], VF vx, VF vy, VF vz, VF constant) {
    return hn::MulAdd(vx, hn::Set(f, r[0]),
                      hn::MulAdd(vy, hn::Set(f, r[1]), hn::MulAdd(vz, hn::Set(f, r[2]), constant)));
  };
  for (size_t i = 0; i < count; i += hn::Lanes(f)) {
    const VF vx = hn::LoadU(f, x + i), vy = hn::LoadU(f, y + i), vz = hn::LoadU(f, z + i);
    const VF w = row(p.w_row, vx, vy, vz, one);
    const VF inverse_w = hn::Div(one, w);
    const VF zero = hn::Zero(f);
    hn::StoreU(hn::MulSub(row(p.x_row, vx, vy, vz, zero), inverse_w, half), f, out.x.data() + i);
    hn::StoreU(hn::MulSub(row(p.y_row, vx, vy, vz, zero), inverse_w, half), f, out.y.data() + i);
    hn::StoreU(w, f, out.w.data() + i);
  }
}

// A batch of triangles ready to be drawn, corners sorted by row.
struct Batch {
  // The lowest corner, the slope of the edge from it to the highest one, and that to the middle
  // one.
  HWY_ALIGN float x_low[kMaxLanes], y_low[kMaxLanes], long_slope[kMaxLanes], lower_slope[kMaxLanes];
  // The middle corner, and the slope of the edge from it to the highest one.
  HWY_ALIGN float x_middle[kMaxLanes], y_middle[kMaxLanes], upper_slope[kMaxLanes];
  HWY_ALIGN int32_t row_begin[kMaxLanes], row_end[kMaxLanes];
  HWY_ALIGN int32_t column_begin[kMaxLanes], column_end[kMaxLanes];  // texel columns
};

struct Corners {
  VF x, y;
};

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
  const VU top = hn::IfThenElseZero(hn::Lt(bits, hn::Set(u, 32)), hn::Shl(hn::Set(u, 1), bits));
  return hn::Sub(top, hn::Set(u, 1));
}

// The next whole number at or above `x`, for |x| < 2²²: adding 1.5 · 2²³ leaves the number in the
// lowest bits of the mantissa. Highway's own conversion spends four more instructions on larger
// numbers.
HWY_INLINE VI CeilToInt(VF x) {
  const F f;
  const I i;
  const VF magic = hn::Set(f, 12582912.0f);
  return hn::Sub(hn::BitCast(i, hn::Add(hn::Ceil(x), magic)), hn::BitCast(i, magic));
}

HWY_INLINE void DrawOne(const Batch& batch, size_t t, uint32_t first_row, uint32_t stride,
                        uint32_t* words) {
  const F f;
  const I i;
  const U u;
  const VF x_low = hn::Set(f, batch.x_low[t]), y_low = hn::Set(f, batch.y_low[t]);
  const VF x_middle = hn::Set(f, batch.x_middle[t]), y_middle = hn::Set(f, batch.y_middle[t]);
  const VF long_slope = hn::Set(f, batch.long_slope[t]);
  const VF lower_slope = hn::Set(f, batch.lower_slope[t]);
  const VF upper_slope = hn::Set(f, batch.upper_slope[t]);
  const int32_t row_end = batch.row_end[t];
  const uint32_t word_begin = static_cast<uint32_t>(batch.column_begin[t]) / 32;
  const uint32_t word_end = (static_cast<uint32_t>(batch.column_end[t]) + 31) / 32;
  for (int32_t base = batch.row_begin[t]; base < row_end;
       base += static_cast<int32_t>(hn::Lanes(f))) {
    const VI row = hn::Iota(i, base);
    const VF y = hn::ConvertTo(f, row);
    const VF from_low = hn::Sub(y, y_low);
    const VF long_x = hn::MulAdd(from_low, long_slope, x_low);
    const VF short_x = hn::IfThenElse(hn::Lt(y, y_middle), hn::MulAdd(from_low, lower_slope, x_low),
                                      hn::MulAdd(hn::Sub(y, y_middle), upper_slope, x_middle));
    const VI left = CeilToInt(hn::Min(long_x, short_x));
    const VI right_end = CeilToInt(hn::Max(long_x, short_x));
    const VI right = hn::IfThenElse(hn::Lt(row, hn::Set(i, row_end)), right_end, left);
    uint32_t* word =
        words + size_t{word_begin} * stride + (static_cast<uint32_t>(base) - first_row);
    for (uint32_t c = word_begin; c < word_end; ++c, word += stride) {
      const VI offset = hn::Set(i, static_cast<int32_t>(32 * c));
      const VU below = LowBits(hn::Max(hn::Sub(left, offset), hn::Zero(i)));
      const VU upto = LowBits(hn::Max(hn::Sub(right, offset), hn::Zero(i)));
      hn::StoreU(hn::Or(hn::LoadU(u, word), hn::AndNot(below, upto)), u, word);
    }
  }
}

HWY_INLINE VF GatherAt(const std::vector<float>& values, VI index) {
  return hn::GatherIndex(F(), values.data(), index);
}

// Lanes as bits of a number.
template <class M>
HWY_INLINE uint32_t Bits(M mask) {
  uint8_t bytes[8] = {};
  hn::StoreMaskBits(F(), mask, bytes);
  return bytes[0] | uint32_t{bytes[1]} << 8;
}

void DrawTriangles(const ProjectedVertices& vertices, const TriangleList& triangles,
                   const TexelWindow& window, bool near_light, ShadowBitmap& bitmap,
                   std::vector<uint32_t>& deferred) {
  const F f;
  const I i;
  const VF zero = hn::Zero(f);
  const VF width = hn::Set(f, static_cast<float>(window.width));
  const VF first_row = hn::Set(f, static_cast<float>(window.row_begin));
  const VF last_row = hn::Set(f, static_cast<float>(window.row_end));
  const VF guard_low = hn::Set(f, -kGuardBand);
  const VF guard_right = hn::Add(width, hn::Set(f, kGuardBand));
  const VF guard_top = hn::Set(f, static_cast<float>(window.row_end) + kGuardBand);
  const VF guard_bottom = hn::Set(f, static_cast<float>(window.row_begin) - kGuardBand);
  Batch batch;
  for (uint32_t t = 0; t < triangles.count; t += hn::Lanes(f)) {
    const VI lane = hn::Iota(i, static_cast<int32_t>(t));
    const auto in_list = hn::Lt(lane, hn::Set(i, static_cast<int32_t>(triangles.count)));
    const VI first = hn::Set(i, static_cast<int32_t>(triangles.first_vertex));
    const auto corner = [&](const uint32_t* corners) {
      const VI index = hn::LoadU(i, reinterpret_cast<const int32_t*>(corners + t));
      return hn::IfThenElseZero(in_list, hn::Sub(index, first));
    };
    const VI index0 = corner(triangles.corner0);
    const VI index1 = corner(triangles.corner1);
    const VI index2 = corner(triangles.corner2);
    Corners a{GatherAt(vertices.x, index0), GatherAt(vertices.y, index0)};
    Corners b{GatherAt(vertices.x, index1), GatherAt(vertices.y, index1)};
    Corners c{GatherAt(vertices.x, index2), GatherAt(vertices.y, index2)};

    // Step 1: leave out what faces away, misses every texel centre or needs more precision.
    auto keep = hn::RebindMask(f, in_list);
    auto too_near = hn::Lt(zero, zero);
    if (near_light) {
      const VF w = hn::Min(hn::Min(GatherAt(vertices.w, index0), GatherAt(vertices.w, index1)),
                           GatherAt(vertices.w, index2));
      too_near = hn::And(keep, hn::Not(hn::Ge(w, hn::Set(f, kNearLightW))));
    } else if (triangles.facing != nullptr) {
      const VF area = hn::MulSub(hn::Sub(b.x, a.x), hn::Sub(c.y, a.y),
                                 hn::Mul(hn::Sub(c.x, a.x), hn::Sub(b.y, a.y)));
      keep = hn::And(keep, hn::Ge(hn::Mul(area, hn::LoadU(f, triangles.facing + t)), zero));
    }
    const VF left = hn::Min(hn::Min(a.x, b.x), c.x), right = hn::Max(hn::Max(a.x, b.x), c.x);
    SortByRow(a, b);
    SortByRow(b, c);
    SortByRow(a, b);
    const VF row_begin = hn::Max(hn::Ceil(a.y), first_row);
    const VF row_end = hn::Min(hn::Ceil(c.y), last_row);
    const VF column_begin = hn::Max(hn::Ceil(left), zero);
    const VF column_end = hn::Min(hn::Ceil(right), width);
    keep = hn::And(keep, hn::And(hn::Lt(row_begin, row_end), hn::Lt(column_begin, column_end)));
    const auto in_guard_band = hn::And(hn::And(hn::Ge(left, guard_low), hn::Le(right, guard_right)),
                                       hn::And(hn::Ge(a.y, guard_bottom), hn::Le(c.y, guard_top)));
    const auto defer = hn::Or(too_near, hn::AndNot(in_guard_band, keep));
    for (uint32_t bits = Bits(defer); bits != 0; bits &= bits - 1) {
      deferred.push_back(t + static_cast<uint32_t>(__builtin_ctz(bits)));
    }
    uint32_t draw = Bits(hn::AndNot(defer, keep));
    if (draw == 0) continue;

    // Step 2: edge slopes. A level edge divides by 0, and no row asks for it.
    hn::Store(a.x, f, batch.x_low);
    hn::Store(a.y, f, batch.y_low);
    hn::Store(b.x, f, batch.x_middle);
    hn::Store(b.y, f, batch.y_middle);
    hn::Store(hn::Div(hn::Sub(c.x, a.x), hn::Sub(c.y, a.y)), f, batch.long_slope);
    hn::Store(hn::Div(hn::Sub(b.x, a.x), hn::Sub(b.y, a.y)), f, batch.lower_slope);
    hn::Store(hn::Div(hn::Sub(c.x, b.x), hn::Sub(c.y, b.y)), f, batch.upper_slope);
    hn::Store(hn::ConvertTo(i, row_begin), i, batch.row_begin);
    hn::Store(hn::ConvertTo(i, row_end), i, batch.row_end);
    hn::Store(hn::ConvertTo(i, column_begin), i, batch.column_begin);
    hn::Store(hn::ConvertTo(i, column_end), i, batch.column_end);

    // Step 3: draw.
    for (; draw != 0; draw &= draw - 1) {
      const auto k = static_cast<size_t>(__builtin_ctz(draw));
      DrawOne(batch, k, window.row_begin, bitmap.stride, bitmap.words.data());
      bitmap.Touch(static_cast<uint32_t>(batch.column_begin[k]) / 32,
                   (static_cast<uint32_t>(batch.column_end[k]) + 31) / 32,
                   static_cast<uint32_t>(batch.row_begin[k]) - window.row_begin,
                   static_cast<uint32_t>(batch.row_end[k]) - window.row_begin);
    }
  }
}

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
      hn::StoreU(hn::DemoteTo(u16, hn::BitCast(I(), sum)), u16, texels + bit);
    }
    const uint32_t in_row = width - 32 * column < 32 ? width - 32 * column : 32;
    for (uint32_t k = 0; k < in_row; ++k) {
      counts[32 * column + k] = static_cast<uint16_t>(counts[32 * column + k] + texels[k]);
    }
  }
}

const char* TargetName() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace penumbra {

HWY_EXPORT(ProjectVertices);
HWY_EXPORT(DrawTriangles);
HWY_EXPORT(AddAndClear);
HWY_EXPORT(AddRowCounts);
HWY_EXPORT(TargetName);

void ProjectVertices(const float* x, const float* y, const float* z, size_t count,
                     const TexelProjection& projection, ProjectedVertices& out) {
  HWY_DYNAMIC_DISPATCH(ProjectVertices)(x, y, z, count, projection, out);
}

void DrawTriangles(const ProjectedVertices& vertices, const TriangleList& triangles,
                   const TexelWindow& window, bool near_light, ShadowBitmap& bitmap,
                   std::vector<uint32_t>& deferred) {
  HWY_DYNAMIC_DISPATCH(DrawTriangles)
  (vertices, triangles, window, near_light, bitmap, deferred);
}

void AddAndClear(ShadowBitmap& bitmap, std::span<std::vector<uint32_t>> planes) {
  HWY_DYNAMIC_DISPATCH(AddAndClear)(bitmap, planes);
}

void AddRowCounts(std::span<const std::vector<uint32_t>> planes, uint32_t stride, uint32_t row,
                  uint32_t width, uint16_t* counts) {
  HWY_DYNAMIC_DISPATCH(AddRowCounts)(planes, stride, row, width, counts);
}

const char* KernelTargetName() { return HWY_DYNAMIC_DISPATCH(TargetName)(); }

}  // namespace penumbra
#endif  // HWY_ONCE
