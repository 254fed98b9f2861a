#include "render/technique/soft_texture/coverage_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/technique/soft_texture/coverage_kernel.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each target
#include "hwy/highway.h"
#include "render/technique/soft_texture/edge_flags.h"
#include "render/technique/soft_texture/kernel_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

void ProjectVertices(const float* x, const float* y, const float* z, size_t count,
                     const TexelProjection& p, ProjectedVertices& out) {
  const F f;
  for (size_t i = 0; i < count; i += hn::Lanes(f)) {
    const Projected projected =
        Project(hn::LoadU(f, x + i), hn::LoadU(f, y + i), hn::LoadU(f, z + i), p);
    hn::StoreU(projected.texel.x, f, out.x.data() + i);
    hn::StoreU(projected.texel.y, f, out.y.data() + i);
    hn::StoreU(projected.w, f, out.w.data() + i);
  }
}

// A batch of triangles ready to be drawn, corners sorted by row.
struct Batch {
  // The lowest corner, and the slopes of the edges from it to the highest and to the middle one.
  HWY_ALIGN float x_low[kMaxLanes], y_low[kMaxLanes], long_slope[kMaxLanes], lower_slope[kMaxLanes];
  // The middle corner, and the slope of the edge from it to the highest one.
  HWY_ALIGN float x_middle[kMaxLanes], y_middle[kMaxLanes], upper_slope[kMaxLanes];
  HWY_ALIGN int32_t row_begin[kMaxLanes], row_end[kMaxLanes];
  HWY_ALIGN int32_t column_begin[kMaxLanes], column_end[kMaxLanes];  // texel columns
};

// The edges of triangle `t`, one value in all lanes.
struct Sides {
  VF x_low, y_low, x_middle, y_middle, long_slope, lower_slope, upper_slope;

  HWY_INLINE Sides(const Batch& batch, size_t t)
      : x_low(hn::Set(F(), batch.x_low[t])),
        y_low(hn::Set(F(), batch.y_low[t])),
        x_middle(hn::Set(F(), batch.x_middle[t])),
        y_middle(hn::Set(F(), batch.y_middle[t])),
        long_slope(hn::Set(F(), batch.long_slope[t])),
        lower_slope(hn::Set(F(), batch.lower_slope[t])),
        upper_slope(hn::Set(F(), batch.upper_slope[t])) {}
};

// The columns [left, right) that the triangle covers in rows `row`; any whole numbers, and none in
// rows from `row_end` on.
struct RowSpans {
  VI left, right;
};

HWY_INLINE RowSpans SpansIn(VI row, const Sides& s, int32_t row_end) {
  const F f;
  const VF y = hn::ConvertTo(f, row);
  const VF from_low = hn::Sub(y, s.y_low);
  const VF long_x = hn::MulAdd(from_low, s.long_slope, s.x_low);
  const VF short_x =
      hn::IfThenElse(hn::Lt(y, s.y_middle), hn::MulAdd(from_low, s.lower_slope, s.x_low),
                     hn::MulAdd(hn::Sub(y, s.y_middle), s.upper_slope, s.x_middle));
  const VI left = CeilToInt(hn::Min(long_x, short_x));
  const VI right = CeilToInt(hn::Max(long_x, short_x));
  return {left, hn::IfThenElse(hn::Lt(row, hn::Set(I(), row_end)), right, left)};
}

HWY_INLINE void DrawOne(const Batch& batch, size_t t, const TexelWindow& window,
                        ShadowBitmap& bitmap) {
  const I i;
  const U u;
  const Sides sides(batch, t);
  const int32_t row_end = batch.row_end[t];
  const uint32_t word_begin = static_cast<uint32_t>(batch.column_begin[t]) / 32;
  const uint32_t word_end = (static_cast<uint32_t>(batch.column_end[t]) + 31) / 32;
  for (int32_t base = batch.row_begin[t]; base < row_end;
       base += static_cast<int32_t>(hn::Lanes(i))) {
    const auto [left, right] = SpansIn(hn::Iota(i, base), sides, row_end);
    uint32_t* word = bitmap.words.data() + size_t{word_begin} * bitmap.stride +
                     (static_cast<uint32_t>(base) - window.row_begin);
    for (uint32_t c = word_begin; c < word_end; ++c, word += bitmap.stride) {
      const VI offset = hn::Set(i, static_cast<int32_t>(32 * c));
      const VU below = LowBits(hn::Max(hn::Sub(left, offset), hn::Zero(i)));
      const VU upto = LowBits(hn::Max(hn::Sub(right, offset), hn::Zero(i)));
      hn::StoreU(hn::Or(hn::LoadU(u, word), hn::AndNot(below, upto)), u, word);
    }
  }
  const auto row = [&](int32_t r) { return static_cast<uint32_t>(r) - window.row_begin; };
  bitmap.Touch(word_begin, word_end, row(batch.row_begin[t]), row(row_end));
}

// One surface more from the left side on, one less from the right side on.
HWY_INLINE void FlagOne(const Batch& batch, size_t t, const TexelWindow& window, EdgeFlags& flags) {
  const I i;
  const Sides sides(batch, t);
  const int32_t row_begin = batch.row_begin[t], row_end = batch.row_end[t];
  const auto lanes = static_cast<int32_t>(hn::Lanes(i));
  const auto width = static_cast<int32_t>(window.width);
  HWY_ALIGN int32_t left[kMaxLanes], right[kMaxLanes];
  for (int32_t base = row_begin; base < row_end; base += lanes) {
    const auto spans = SpansIn(hn::Iota(i, base), sides, row_end);
    hn::Store(hn::Max(spans.left, hn::Zero(i)), i, left);
    hn::Store(hn::Max(spans.right, hn::Zero(i)), i, right);
    for (int32_t r = 0; r < std::min(lanes, row_end - base); ++r) {
      if (left[r] >= right[r]) continue;
      int32_t* const row = &flags.change[static_cast<uint32_t>(base + r) - window.row_begin];
      if (left[r] < width) row[size_t(left[r]) * flags.stride] += 1;
      if (right[r] < width) row[size_t(right[r]) * flags.stride] -= 1;
    }
  }
  const auto column_end = static_cast<uint32_t>(batch.column_end[t]);
  flags.Touch(static_cast<uint32_t>(batch.column_begin[t]), std::min(column_end + 1, window.width),
              static_cast<uint32_t>(row_begin) - window.row_begin,
              static_cast<uint32_t>(row_end) - window.row_begin);
}

HWY_INLINE VF GatherAt(const std::vector<float>& values, VI index) {
  return hn::GatherIndex(F(), values.data(), index);
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

// How far past its edge's end, in texels, rounding may put a crossing: see kGuardBand.
constexpr float kCrossingSlack = 0x1.0p-10f;

// The rows and columns of texel centres that the triangles may cover, cut to the window.
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
  hn::Store(SlopeBetween(low, high), f, batch.long_slope);
  hn::Store(SlopeBetween(low, middle), f, batch.lower_slope);
  hn::Store(SlopeBetween(middle, high), f, batch.upper_slope);
  hn::Store(hn::ConvertTo(i, extent.row_begin), i, batch.row_begin);
  hn::Store(hn::ConvertTo(i, extent.row_end), i, batch.row_end);
  hn::Store(hn::ConvertTo(i, extent.column_begin), i, batch.column_begin);
  hn::Store(hn::ConvertTo(i, extent.column_end), i, batch.column_end);
}

// Lanes to draw and lanes to leave to double precision, as bits.
struct Selection {
  uint32_t draw, defer;
};

// Leaves out what faces away or misses every texel centre, tells what needs more precision, stores
// the rest.
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
  const VF left = hn::Sub(hn::Min(hn::Min(low.x, middle.x), high.x), constant(kCrossingSlack));
  const VF right = hn::Add(hn::Max(hn::Max(low.x, middle.x), high.x), constant(kCrossingSlack));
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

// Calls `put(batch, k)` for every triangle to be drawn.
template <class Put>
HWY_INLINE void ForEachTriangle(const ProjectedVertices& vertices, const TriangleList& triangles,
                                const TexelWindow& window, bool near_light,
                                std::vector<uint32_t>& deferred, const Put& put) {
  Batch batch = {};
  for (uint32_t t = 0; t < triangles.count; t += hn::Lanes(F())) {
    auto [draw, defer] = SelectAndStore(vertices, triangles, t, window, near_light, batch);
    for (; defer != 0; defer &= defer - 1) {
      deferred.push_back(t + static_cast<uint32_t>(__builtin_ctz(defer)));
    }
    for (; draw != 0; draw &= draw - 1) put(batch, static_cast<size_t>(__builtin_ctz(draw)));
  }
}

void DrawTriangles(const ProjectedVertices& vertices, const TriangleList& triangles,
                   const TexelWindow& window, bool near_light, ShadowBitmap& bitmap,
                   std::vector<uint32_t>& deferred) {
  ForEachTriangle(vertices, triangles, window, near_light, deferred,
                  [&](const Batch& batch, size_t k)
                      HWY_ATTR { DrawOne(batch, k, window, bitmap); });
}

void FlagTriangles(const ProjectedVertices& vertices, const TriangleList& triangles,
                   const TexelWindow& window, bool near_light, EdgeFlags& flags,
                   std::vector<uint32_t>& deferred) {
  ForEachTriangle(vertices, triangles, window, near_light, deferred,
                  [&](const Batch& batch, size_t k) HWY_ATTR { FlagOne(batch, k, window, flags); });
}

const char* TargetName() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace penumbra {

HWY_EXPORT(ProjectVertices);
HWY_EXPORT(DrawTriangles);
HWY_EXPORT(FlagTriangles);
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

void FlagTriangles(const ProjectedVertices& vertices, const TriangleList& triangles,
                   const TexelWindow& window, bool near_light, EdgeFlags& flags,
                   std::vector<uint32_t>& deferred) {
  HWY_DYNAMIC_DISPATCH(FlagTriangles)
  (vertices, triangles, window, near_light, flags, deferred);
}

const char* KernelTargetName() { return HWY_DYNAMIC_DISPATCH(TargetName)(); }

}  // namespace penumbra
#endif  // HWY_ONCE
