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

// One lane a triangle.
struct TriangleLanes {
  VI index0, index1, index2;
  Corners a, b, c;
  decltype(hn::Lt(VI(), VI())) in_list;  // false past the list's end
};

HWY_INLINE TriangleLanes LoadTriangles(const ProjectedVertices& vertices,
                                       const TriangleList& triangles, uint32_t t) {
  const I i;
  TriangleLanes lanes;
  lanes.in_list = hn::Lt(hn::Iota(i, static_cast<int32_t>(t)),
                         hn::Set(i, static_cast<int32_t>(triangles.count)));
  const VI first = hn::Set(i, static_cast<int32_t>(triangles.first_vertex));
  const auto corner = [&](const uint32_t* corners) HWY_ATTR {
    const VI index = hn::LoadU(i, reinterpret_cast<const int32_t*>(corners + t));
    return hn::IfThenElseZero(lanes.in_list, hn::Sub(index, first));
  };
  lanes.index0 = corner(triangles.corner0);
  lanes.index1 = corner(triangles.corner1);
  lanes.index2 = corner(triangles.corner2);
  lanes.a = {GatherAt(vertices.x, lanes.index0), GatherAt(vertices.y, lanes.index0)};
  lanes.b = {GatherAt(vertices.x, lanes.index1), GatherAt(vertices.y, lanes.index1)};
  lanes.c = {GatherAt(vertices.x, lanes.index2), GatherAt(vertices.y, lanes.index2)};
  return lanes;
}

// Whether a triangle's projected area has the sign that it needs to face the light.
HWY_INLINE auto FacesLight(const TriangleLanes& lanes, const float* facing) {
  const F f;
  const VF area = hn::MulSub(hn::Sub(lanes.b.x, lanes.a.x), hn::Sub(lanes.c.y, lanes.a.y),
                             hn::Mul(hn::Sub(lanes.c.x, lanes.a.x), hn::Sub(lanes.b.y, lanes.a.y)));
  return hn::Ge(hn::Mul(area, hn::LoadU(f, facing)), hn::Zero(f));
}

HWY_INLINE auto TooNearLight(const ProjectedVertices& vertices, const TriangleLanes& lanes) {
  const VF w =
      hn::Min(hn::Min(GatherAt(vertices.w, lanes.index0), GatherAt(vertices.w, lanes.index1)),
              GatherAt(vertices.w, lanes.index2));
  return hn::Not(hn::Ge(w, hn::Set(F(), kNearLightW)));
}

// The rows and columns of texel centres that the triangles span, cut to the window.
struct Extent {
  VF row_begin, row_end, column_begin, column_end;
};

// Edge slopes. A level edge divides by 0, and no row asks for it.
HWY_INLINE void StoreBatch(const Corners& low, const Corners& middle, const Corners& high,
                           const Extent& extent, Batch& batch) {
  const F f;
  const I i;
  hn::Store(low.x, f, batch.x_low);
  hn::Store(low.y, f, batch.y_low);
  hn::Store(middle.x, f, batch.x_middle);
  hn::Store(middle.y, f, batch.y_middle);
  const auto slope = [](const Corners& from, const Corners& to)
                         HWY_ATTR { return hn::Div(hn::Sub(to.x, from.x), hn::Sub(to.y, from.y)); };
  hn::Store(slope(low, high), f, batch.long_slope);
  hn::Store(slope(low, middle), f, batch.lower_slope);
  hn::Store(slope(middle, high), f, batch.upper_slope);
  hn::Store(hn::ConvertTo(i, extent.row_begin), i, batch.row_begin);
  hn::Store(hn::ConvertTo(i, extent.row_end), i, batch.row_end);
  hn::Store(hn::ConvertTo(i, extent.column_begin), i, batch.column_begin);
  hn::Store(hn::ConvertTo(i, extent.column_end), i, batch.column_end);
}

// Lanes to draw and lanes to leave to double precision, as bits.
struct Selection {
  uint32_t draw, defer;
};

// Leaves out what faces away or misses every texel centre, tells what needs more precision, and
// stores the rest.
HWY_INLINE Selection SelectAndStore(const ProjectedVertices& vertices,
                                    const TriangleList& triangles, uint32_t t,
                                    const TexelWindow& window, bool near_light, Batch& batch) {
  const F f;
  const auto constant = [&](float value) HWY_ATTR { return hn::Set(f, value); };
  const auto width = static_cast<float>(window.width);
  const auto first_row = static_cast<float>(window.row_begin);
  const auto last_row = static_cast<float>(window.row_end);
  TriangleLanes lanes = LoadTriangles(vertices, triangles, t);
  auto keep = hn::RebindMask(f, lanes.in_list);
  auto too_near = hn::Lt(hn::Zero(f), hn::Zero(f));
  if (near_light) {
    too_near = hn::And(keep, TooNearLight(vertices, lanes));
  } else if (triangles.facing != nullptr) {
    keep = hn::And(keep, FacesLight(lanes, triangles.facing + t));
  }
  Corners &low = lanes.a, &middle = lanes.b, &high = lanes.c;
  const VF left = hn::Min(hn::Min(low.x, middle.x), high.x);
  const VF right = hn::Max(hn::Max(low.x, middle.x), high.x);
  SortByRow(low, middle);
  SortByRow(middle, high);
  SortByRow(low, middle);
  const Extent extent{
      hn::Max(hn::Ceil(low.y), constant(first_row)), hn::Min(hn::Ceil(high.y), constant(last_row)),
      hn::Max(hn::Ceil(left), hn::Zero(f)), hn::Min(hn::Ceil(right), constant(width))};
  keep = hn::And(keep, hn::And(hn::Lt(extent.row_begin, extent.row_end),
                               hn::Lt(extent.column_begin, extent.column_end)));
  const auto in_guard_band = hn::And(
      hn::And(hn::Ge(left, constant(-kGuardBand)), hn::Le(right, constant(width + kGuardBand))),
      hn::And(hn::Ge(low.y, constant(first_row - kGuardBand)),
              hn::Le(high.y, constant(last_row + kGuardBand))));
  const auto defer = hn::Or(too_near, hn::AndNot(in_guard_band, keep));
  const Selection selection{Bits(hn::AndNot(defer, keep)), Bits(defer)};
  if (selection.draw != 0) StoreBatch(low, middle, high, extent, batch);
  return selection;
}

void DrawTriangles(const ProjectedVertices& vertices, const TriangleList& triangles,
                   const TexelWindow& window, bool near_light, ShadowBitmap& bitmap,
                   std::vector<uint32_t>& deferred) {
  Batch batch = {};
  for (uint32_t t = 0; t < triangles.count; t += hn::Lanes(F())) {
    auto [draw, defer] = SelectAndStore(vertices, triangles, t, window, near_light, batch);
    for (; defer != 0; defer &= defer - 1) {
      deferred.push_back(t + static_cast<uint32_t>(__builtin_ctz(defer)));
    }
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

const char* TargetName() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace penumbra {

HWY_EXPORT(ProjectVertices);
HWY_EXPORT(DrawTriangles);
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

const char* KernelTargetName() { return HWY_DYNAMIC_DISPATCH(TargetName)(); }

}  // namespace penumbra
#endif  // HWY_ONCE
