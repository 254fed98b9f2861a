#include "render/light_view/raster_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/light_view/raster_kernel.cc"
#include <algorithm>
#include <cmath>
#include <utility>

#include "hwy/foreach_target.h"  // compiles this file once for each target
#include "hwy/highway.h"
#include "render/light_view/raster_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

// Far outside: what has this x wants care.
constexpr float kNowhere = 4 * kMaxReach;

HWY_INLINE void ProjectAll(const RasterCluster& c, const RasterProjection& p, RasterVertices& out) {
  const F f;
  const VF scale_x = hn::Set(f, p.scale_x), scale_y = hn::Set(f, p.scale_y);
  const VF offset_x = hn::Set(f, p.offset_x), offset_y = hn::Set(f, p.offset_y);
  const VF eye_x = hn::Set(f, p.eye_x), eye_y = hn::Set(f, p.eye_y), eye_z = hn::Set(f, p.eye_z);
  const VF unplaced = hn::Set(f, kNowhere);
  for (size_t i = 0; i < c.vertex_count; i += hn::Lanes(f)) {
    const VF x = hn::LoadU(f, c.x + i), y = hn::LoadU(f, c.y + i), z = hn::LoadU(f, c.z + i);
    VF at_x, at_y, near;
    if (p.from_infinity) {
      at_x = hn::MulSub(hn::MulAdd(z, eye_x, x), scale_x, offset_x);
      at_y = hn::MulSub(hn::MulAdd(z, eye_y, y), scale_y, offset_y);
      near = hn::Neg(z);
    } else {
      const VF depth = hn::Sub(z, eye_z);
      near = hn::Div(hn::Set(f, 1.0f), depth);
      const auto is_far = hn::Ge(depth, hn::Set(f, p.careful_depth));
      at_x = hn::MulSub(hn::Mul(hn::Sub(x, eye_x), near), scale_x, offset_x);
      at_y = hn::MulSub(hn::Mul(hn::Sub(y, eye_y), near), scale_y, offset_y);
      at_x = hn::IfThenElse(is_far, at_x, unplaced);
      at_y = hn::IfThenElse(is_far, at_y, unplaced);
    }
    hn::StoreInterleaved4(at_x, at_y, hn::Neg(at_x), hn::Neg(at_y), f, out.corners + 4 * i);
    hn::Store(near, f, out.near + i);
  }
}

// One pixel, whichever way the triangle turns.
HWY_INLINE void FillPixel(const RasterVertices& v, const uint16_t* corners, const PixelBox& box,
                          const RasterImage& image) {
  const F1 f;
  const Vec2 a = v.At(corners[0]), b = v.At(corners[1]), c = v.At(corners[2]);
  const auto py = static_cast<float>(box.first_y()) + 0.5f;
  const auto px = hn::Set(f, static_cast<float>(box.first_x()) + 0.5f);
  const float ka = hn::GetLane(EdgeInRow<F1>(Edge(b, c), py).At(px));
  const float kb = hn::GetLane(EdgeInRow<F1>(Edge(c, a), py).At(px));
  const float kc = hn::GetLane(EdgeInRow<F1>(Edge(a, b), py).At(px));
  const float lo = std::min({ka, kb, kc}), hi = std::max({ka, kb, kc});
  if (!(lo >= 0 ? hi > 0 : hi <= 0)) return;
  const float na = v.near[corners[0]], nb = v.near[corners[1]], nc = v.near[corners[2]];
  const float blend = (ka * na + kb * nb + kc * nc) / (ka + kb + kc);
  const float near = std::clamp(blend, std::min({na, nb, nc}), std::max({na, nb, nc}));
  float& pixel = image.nearest[static_cast<size_t>(box.first_y()) * image.width + box.first_x()];
  pixel = std::max(pixel, near);
}

// Keeps the nearer of what is there and what is drawn.
struct KeepNearer {
  HWY_INLINE void operator()(VF near, hn::Mask<F> inside, float* row, int x, int /*y*/) const {
    const F f;
    const VF old = hn::LoadU(f, row + x);
    hn::StoreU(hn::IfThenElse(inside, hn::Max(old, near), old), f, row + x);
  }
};

// The same where the mask is.
struct KeepNearerUncut {
  const RasterPlanes& planes;
  const RasterCut& cut;

  HWY_INLINE void operator()(VF near, hn::Mask<F> inside, float* row, int x, int y) const {
    const F f;
    const auto is_nearer = hn::And(inside, hn::Gt(near, hn::LoadU(f, row + x)));
    if (hn::AllFalse(f, is_nearer)) return;
    HWY_ALIGN float nears[kRasterLanes];
    HWY_ALIGN float marks[kRasterLanes];
    hn::Store(near, f, nears);
    hn::Store(hn::IfThenElseZero(is_nearer, hn::Set(f, 1.0f)), f, marks);
    for (int k = 0; k < static_cast<int>(hn::Lanes(f)); ++k) {
      if (marks[k] != 0 && IsThere(x + k + 0.5, y + 0.5)) row[x + k] = nears[k];
    }
  }

  HWY_INLINE bool IsThere(double px, double py) const {
    const double w = cut.from_infinity ? 1.0 : planes.near.At(px, py);
    const DVec2 uv = DVec2(planes.u.At(px, py), planes.v.At(px, py)) / w;
    return cut.mask->At(Vec2(uv)) >= cut.cutoff;
  }
};

// The corners counter-clockwise, x to the right and y up.
template <class Keep>
HWY_INLINE void FillRows(Vec2 a, Vec2 b, Vec2 c, const RasterPlanes& planes, const PixelBox& box,
                         const RasterImage& image, const Keep& keep) {
  const F f;
  const Edge ea(b, c), eb(c, a), ec(a, b);
  const VF least = hn::Set(f, planes.least), most = hn::Set(f, planes.most);
  const VF zero = hn::Zero(f), lane = hn::Iota(f, 0);
  const VF end = hn::Set(f, static_cast<float>(box.last_x() + 1));
  // Nearly from its edge a plane is steeper than single precision can say, and ∞ · 0 is no number.
  const double steepest = 1e30;
  const double across = planes.near.per_column;
  const VF per_column = hn::Set(f, static_cast<float>(std::clamp(across, -steepest, steepest)));
  for (int y = box.first_y(); y <= box.last_y(); ++y) {
    const float py = static_cast<float>(y) + 0.5f;
    const EdgeInRow<F> ra(ea, py), rb(eb, py), rc(ec, py);
    Span span{static_cast<float>(box.first_x()), static_cast<float>(box.last_x())};
    for (const Edge* edge : {&ea, &eb, &ec}) span.CutBy(*edge, py);
    if (!(span.first <= span.last)) continue;
    const double in_row = planes.near.At(0.5, y + 0.5);
    float* const row = image.nearest + static_cast<size_t>(y) * image.width;
    const auto first = static_cast<int>(span.first), last = static_cast<int>(span.last);
    for (int x = first; x <= last; x += static_cast<int>(hn::Lanes(f))) {
      const VF px = hn::Add(hn::Set(f, static_cast<float>(x) + 0.5f), lane);
      const VF inside_by = hn::Min(ra.At(px), hn::Min(rb.At(px), rc.At(px)));
      const auto inside = hn::And(hn::Ge(inside_by, zero), hn::Lt(px, end));
      if (hn::AllFalse(f, inside)) continue;
      const VF start = hn::Set(f, static_cast<float>(in_row + across * x));
      keep(hn::Min(hn::Max(hn::MulAdd(per_column, lane, start), least), most), inside, row, x, y);
    }
  }
}

HWY_INLINE void FillBox(Vec2 a, Vec2 b, Vec2 c, double area2, const RasterPlanes& planes,
                        const PixelBox& box, const RasterImage& image, const RasterCut* cut) {
  if (area2 < 0) std::swap(b, c);
  if (cut) {
    FillRows(a, b, c, planes, box, image, KeepNearerUncut{planes, *cut});
  } else {
    FillRows(a, b, c, planes, box, image, KeepNearer());
  }
}

HWY_INLINE double TwiceArea(Vec2 a, Vec2 b, Vec2 c) {
  const DVec2 ab = DVec2(b) - DVec2(a), ac = DVec2(c) - DVec2(a);
  return ab.x * ac.y - ab.y * ac.x;
}

// The plane through three corners' values.
HWY_INLINE LinearField PlaneThrough(Vec2 a, Vec2 b, Vec2 c, DVec3 values, double area2) {
  const DVec2 ab = DVec2(b) - DVec2(a), ac = DVec2(c) - DVec2(a);
  const double to_b = values.y - values.x, to_c = values.z - values.x;
  LinearField plane{.per_column = (to_b * ac.y - to_c * ab.y) / area2,
                    .per_row = (to_c * ab.x - to_b * ac.x) / area2};
  plane.at_origin = values.x - plane.per_column * a.x - plane.per_row * a.y;
  return plane;
}

HWY_INLINE void FillTriangle(const RasterVertices& v, const uint16_t* corners, const PixelBox& box,
                             const RasterImage& image, const RasterCut* cut) {
  const Vec2 a = v.At(corners[0]), b = v.At(corners[1]), c = v.At(corners[2]);
  const double area2 = TwiceArea(a, b, c);
  if (area2 == 0) return;  // seen from its edge
  const Vec3 nears(v.near[corners[0]], v.near[corners[1]], v.near[corners[2]]);
  RasterPlanes planes{.near = PlaneThrough(a, b, c, DVec3(nears), area2),
                      .least = std::min({nears.x, nears.y, nears.z}),
                      .most = std::max({nears.x, nears.y, nears.z})};
  if (cut) {
    DVec3 us, vs;
    for (int k = 0; k < 3; ++k) {
      const DVec2 uv(cut->uvs[cut->vertices[corners[k]]]);
      const double w = cut->from_infinity ? 1.0 : nears[k];
      us[k] = uv.x * w, vs[k] = uv.y * w;
    }
    planes.u = PlaneThrough(a, b, c, us, area2);
    planes.v = PlaneThrough(a, b, c, vs, area2);
  }
  FillBox(a, b, c, area2, planes, box, image, cut);
}

size_t DrawCluster(const RasterCluster& cluster, const RasterProjection& projection,
                   const RasterImage& image, const RasterCut* cut, RasterVertices& v,
                   uint16_t* deferred) {
  ProjectAll(cluster, projection, v);
  HWY_ALIGN const float sides[4] = {0, 0, static_cast<float>(1 - image.width),
                                    static_cast<float>(1 - image.height)};
  size_t deferred_count = 0;
  for (size_t t = 0; t < cluster.triangle_count; ++t) {
    const uint16_t* const corners = cluster.corners + 3 * t;
    PixelBox box;
    const Coverage coverage = CoverageOf(v, corners, sides, box);
    if (coverage == Coverage::kNone) continue;
    if (coverage == Coverage::kUnplaced) {
      deferred[deferred_count++] = static_cast<uint16_t>(t);
    } else if (coverage == Coverage::kOnePixel && !cut) {
      FillPixel(v, corners, box, image);
    } else {
      FillTriangle(v, corners, box, image, cut);
    }
  }
  return deferred_count;
}

void DrawTriangle(const std::array<Vec2, 3>& corners, const RasterPlanes& planes,
                  const RasterImage& image, const RasterCut* cut) {
  const auto& [a, b, c] = corners;
  const double area2 = TwiceArea(a, b, c);
  // Seen from its edge it is not seen.
  if (!(std::abs(area2) > 0 && std::isfinite(planes.near.At(1, 1)))) return;
  const Vec2 lo = glm::min(a, glm::min(b, c)), hi = glm::max(a, glm::max(b, c));
  PixelBox box;
  const int32_t image_sides[2] = {image.width, image.height};
  for (int k = 0; k < 2; ++k) {
    box.sides[k] = std::max(static_cast<int32_t>(std::ceil(lo[k] - 0.5f)), 0);
    box.sides[2 + k] = std::min(static_cast<int32_t>(std::floor(hi[k] - 0.5f)), image_sides[k] - 1);
    if (box.sides[k] > box.sides[2 + k]) return;
  }
  FillBox(a, b, c, area2, planes, box, image, cut);
}

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace penumbra {

HWY_EXPORT(DrawCluster);
HWY_EXPORT(DrawTriangle);

size_t DrawCluster(const RasterCluster& cluster, const RasterProjection& projection,
                   const RasterImage& image, const RasterCut* cut, RasterVertices& vertices,
                   uint16_t* deferred) {
  return HWY_DYNAMIC_DISPATCH(DrawCluster)(cluster, projection, image, cut, vertices, deferred);
}

void DrawTriangle(const std::array<Vec2, 3>& corners, const RasterPlanes& planes,
                  const RasterImage& image, const RasterCut* cut) {
  HWY_DYNAMIC_DISPATCH(DrawTriangle)(corners, planes, image, cut);
}

}  // namespace penumbra
#endif  // HWY_ONCE
