#include "render/technique/coherent_raytrace/square_kernel.h"

#include <algorithm>
#include <numbers>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/technique/coherent_raytrace/square_kernel.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each target
// After it.
#include "hwy/contrib/math/math-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, kSamplerLanes>;
using I = hn::RebindToSigned<F>;
using VF = hn::Vec<F>;
using MF = hn::Mask<F>;
using Kind = SquareKind;

HWY_INLINE VF All(float value) { return hn::Set(F(), value); }

HWY_INLINE VF Dot(VF x, VF y, VF z, Vec3 v) {
  return hn::MulAdd(x, All(v.x), hn::MulAdd(y, All(v.y), hn::Mul(z, All(v.z))));
}

HWY_INLINE VF Squared(VF x, VF y) { return hn::MulAdd(x, x, hn::Mul(y, y)); }
HWY_INLINE VF Squared(VF x, VF y, VF z) { return hn::MulAdd(x, x, Squared(y, z)); }

// Of two coordinates, not both 0, the smaller over the larger.
HWY_INLINE VF Ratio(VF smaller, VF larger) {
  return hn::IfThenElseZero(hn::Ne(larger, hn::Zero(F())), hn::Div(smaller, larger));
}

// ConcentricDisk.
HWY_INLINE void ToDisk(VF& s, VF& t) {
  constexpr float kQuarter = std::numbers::pi_v<float> / 4;
  const VF p = hn::MulAdd(All(2), s, All(-1)), q = hn::MulAdd(All(2), t, All(-1));
  const MF wide = hn::Gt(hn::Abs(p), hn::Abs(q));
  const VF radius = hn::IfThenElse(wide, p, q);
  // From the axis that it is closer to.
  const VF angle = hn::Mul(All(kQuarter), Ratio(hn::IfThenElse(wide, q, p), radius));
  const VF along = hn::Mul(radius, hn::Cos(F(), angle));
  const VF across = hn::Mul(radius, hn::Sin(F(), angle));
  s = hn::IfThenElse(wide, along, across);
  t = hn::IfThenElse(wide, across, along);
}

// ConcentricSquare.
HWY_INLINE void ToSquare(VF& s, VF& t) {
  constexpr float kPerRadian = 4 / std::numbers::pi_v<float>;
  const MF wide = hn::Gt(hn::Abs(s), hn::Abs(t));
  const VF larger = hn::IfThenElse(wide, s, t);
  const VF ratio = Ratio(hn::IfThenElse(wide, t, s), larger);
  const VF along = hn::CopySign(hn::Sqrt(Squared(s, t)), larger);
  const VF across = hn::Mul(hn::Mul(along, All(kPerRadian)), hn::Atan(F(), ratio));
  s = hn::MulAdd(All(0.5f), hn::IfThenElse(wide, along, across), All(0.5f));
  t = hn::MulAdd(All(0.5f), hn::IfThenElse(wide, across, along), All(0.5f));
}

// Where the ways from the point to blockers go on to meet the light. False where they do not, or
// only before the blocker.
template <Kind kKind>
HWY_INLINE MF PlaceBehind(const SquareView& view, VF way_x, VF way_y, VF way_z, VF& s, VF& t) {
  constexpr bool kIsFlat = kKind == Kind::kRectangle || kKind == Kind::kDisk;
  const VF along_n = Dot(way_x, way_y, way_z, view.n);
  const VF along_u = Dot(way_x, way_y, way_z, kIsFlat ? view.dual_u : view.u);
  const VF along_v = Dot(way_x, way_y, way_z, kIsFlat ? view.dual_v : view.v);
  if constexpr (kIsFlat) {
    const VF stretch = hn::Div(All(view.height), along_n);
    s = hn::MulAdd(stretch, along_u, All(view.along_u));
    t = hn::MulAdd(stretch, along_v, All(view.along_v));
    return hn::Gt(stretch, All(1));
  }
  const VF length = hn::Sqrt(Squared(way_x, way_y, way_z));
  if constexpr (kKind == Kind::kSky) {
    const VF scale = hn::Div(All(1 / view.radius), length);
    s = hn::Mul(scale, along_u), t = hn::Mul(scale, along_v);
    return hn::Gt(along_n, hn::Zero(F()));
  }
  // The sphere's axis n is the way to its centre; u and v are across it.
  const VF inverse = hn::Div(All(1), length);
  const float to_center = glm::distance(view.point, view.origin);
  const VF cos_u = hn::Mul(inverse, along_u), cos_v = hn::Mul(inverse, along_v);
  const VF sin2 = Squared(cos_u, cos_v);
  // How far from the centre the ray goes by, and half the length of it inside.
  const VF inside2 =
      hn::NegMulAdd(All(to_center * to_center), sin2, All(view.radius * view.radius));
  const VF half = hn::Sqrt(hn::Max(inside2, hn::Zero(F())));
  const VF distance = hn::MulSub(All(to_center), hn::Mul(inverse, along_n), half);
  s = hn::Mul(hn::Mul(distance, cos_u), All(1 / view.radius));
  t = hn::Mul(hn::Mul(distance, cos_v), All(1 / view.radius));
  return hn::And(hn::Ge(inside2, hn::Zero(F())), hn::Gt(distance, length));
}

// Whether a place is on the light, which makes it one on the square.
template <Kind kKind>
HWY_INLINE MF IsOnLight(VF& s, VF& t) {
  const VF zero = hn::Zero(F()), one = All(1);
  if constexpr (kKind == Kind::kRectangle) {
    return hn::And(hn::And(hn::Ge(s, zero), hn::Lt(s, one)),
                   hn::And(hn::Ge(t, zero), hn::Lt(t, one)));
  }
  const MF is_on = hn::Lt(Squared(s, t), one);
  ToSquare(s, t);
  return is_on;
}

template <Kind kKind>
void PartsBehindOf(const SquareView& view, const CellGrid& grid, const Vec4* blockers, size_t count,
                   uint32_t* part) {
  const F f;
  const I i;
  const auto along = hn::Set(i, static_cast<int32_t>(grid.along()));
  const auto last = hn::Set(i, static_cast<int32_t>(grid.along()) - 1);
  const auto off = hn::Set(i, static_cast<int32_t>(grid.off()));
  const VF size = All(static_cast<float>(grid.along()));
  for (size_t k = 0; k < count; k += hn::Lanes(f)) {
    VF x, y, z, unused, s, t;
    hn::LoadInterleaved4(f, &blockers[k].x, x, y, z, unused);
    const MF is_before =
        PlaceBehind<kKind>(view, hn::Sub(x, All(view.point.x)), hn::Sub(y, All(view.point.y)),
                           hn::Sub(z, All(view.point.z)), s, t);
    const MF is_hidden = hn::And(is_before, IsOnLight<kKind>(s, t));
    const auto number = [&](VF place) HWY_ATTR {
      return hn::Min(hn::ConvertTo(i, hn::IfThenElseZero(is_hidden, hn::Mul(place, size))), last);
    };
    const auto at = hn::IfThenElse(hn::RebindMask(i, is_hidden),
                                   hn::Add(hn::Mul(number(t), along), number(s)), off);
    const hn::RebindToUnsigned<I> unsigned_lanes;
    hn::StoreU(hn::BitCast(unsigned_lanes, at), unsigned_lanes, part + k);
  }
}

// The point of the light at a place.
template <Kind kKind>
HWY_INLINE void PointAt(const SquareView& view, VF s, VF t, VF& x, VF& y, VF& z) {
  VF bulge = hn::Zero(F());  // along n
  if constexpr (kKind == Kind::kSphere || kKind == Kind::kSky) {
    s = hn::Mul(s, All(view.radius)), t = hn::Mul(t, All(view.radius));
    const float radius2 = kKind == Kind::kSky ? 1.0f : view.radius * view.radius;
    bulge = hn::Sqrt(hn::Max(hn::Sub(All(radius2), Squared(s, t)), hn::Zero(F())));
    if constexpr (kKind == Kind::kSphere) bulge = hn::Neg(bulge);  // towards the point
  }
  const auto combined = [&](float origin, float u, float v, float n) HWY_ATTR {
    const VF on_plane = hn::MulAdd(s, All(u), hn::MulAdd(t, All(v), All(origin)));
    return kKind == Kind::kSphere || kKind == Kind::kSky ? hn::MulAdd(bulge, All(n), on_plane)
                                                         : on_plane;
  };
  const Vec3 origin = kKind == Kind::kSky ? Vec3(0.0f) : view.origin;
  x = combined(origin.x, view.u.x, view.v.x, view.n.x);
  y = combined(origin.y, view.u.y, view.v.y, view.n.y);
  z = combined(origin.z, view.u.z, view.v.z, view.n.z);
}

template <Kind kKind>
void TargetsAtOf(const SquareView& view, size_t count, const float* u, const float* v, float* x,
                 float* y, float* z) {
  const F f;
  for (size_t k = 0; k < count; k += hn::Lanes(f)) {
    VF s = hn::LoadU(f, u + k), t = hn::LoadU(f, v + k), at_x, at_y, at_z;
    if constexpr (kKind != Kind::kRectangle) ToDisk(s, t);
    PointAt<kKind>(view, s, t, at_x, at_y, at_z);
    hn::StoreU(at_x, f, x + k);
    hn::StoreU(at_y, f, y + k);
    hn::StoreU(at_z, f, z + k);
  }
}

template <Kind kKind>
HWY_INLINE VF WeightAt(const SquareView& view, const Vec3& normal, VF s, VF t) {
  VF x, y, z;
  PointAt<kKind>(view, s, t, x, y, z);
  const VF zero = hn::Zero(F());
  if constexpr (kKind == Kind::kSky) {
    return hn::Div(hn::Max(Dot(x, y, z, normal), zero), hn::Max(Dot(x, y, z, view.n), All(1e-6f)));
  }
  const VF way_x = hn::Sub(x, All(view.point.x)), way_y = hn::Sub(y, All(view.point.y)),
           way_z = hn::Sub(z, All(view.point.z));
  const VF distance2 = Squared(way_x, way_y, way_z);
  VF cosines = hn::Max(Dot(way_x, way_y, way_z, normal), zero);
  if constexpr (kKind == Kind::kSphere) {
    // An area of the disc is one of the sphere times its cosine to the disc's axis.
    const VF out_x = hn::Sub(All(view.origin.x), x), out_y = hn::Sub(All(view.origin.y), y),
             out_z = hn::Sub(All(view.origin.z), z);
    const VF to_light = hn::MulAdd(out_x, way_x, hn::MulAdd(out_y, way_y, hn::Mul(out_z, way_z)));
    const VF to_axis = hn::Max(Dot(out_x, out_y, out_z, view.n), All(1e-3f * view.radius));
    cosines = hn::Mul(cosines, hn::Div(hn::Max(to_light, zero), to_axis));
  }
  return hn::IfThenElseZero(hn::Gt(distance2, zero),
                            hn::Div(cosines, hn::Mul(distance2, distance2)));
}

template <Kind kKind>
void WeightsAtOf(const SquareView& view, const Vec3& normal, size_t count, const float* s,
                 const float* t, float* weight) {
  const F f;
  for (size_t k = 0; k < count; k += hn::Lanes(f)) {
    hn::StoreU(WeightAt<kKind>(view, normal, hn::LoadU(f, s + k), hn::LoadU(f, t + k)), f,
               weight + k);
  }
}

// Calls work<kind>(); kinds that are single points do not come here.
template <typename Work>
HWY_INLINE void ForKind(Kind kind, const Work& work) {
  switch (kind) {
    case Kind::kRectangle:
      return work.template operator()<Kind::kRectangle>();
    case Kind::kDisk:
      return work.template operator()<Kind::kDisk>();
    case Kind::kSphere:
      return work.template operator()<Kind::kSphere>();
    case Kind::kSky:
      return work.template operator()<Kind::kSky>();
    case Kind::kPoint:
    case Kind::kDirection:
      break;
  }
}

void PartsBehind(const SquareView& view, const CellGrid& grid, const Vec4* blockers, size_t count,
                 uint32_t* part) {
  ForKind(view.kind,
          [&]<Kind kKind>() HWY_ATTR { PartsBehindOf<kKind>(view, grid, blockers, count, part); });
}

void TargetsAt(const SquareView& view, size_t count, const float* u, const float* v, float* x,
               float* y, float* z) {
  ForKind(view.kind,
          [&]<Kind kKind>() HWY_ATTR { TargetsAtOf<kKind>(view, count, u, v, x, y, z); });
}

void WeightsAt(const SquareView& view, const Vec3& normal, size_t count, const float* s,
               const float* t, float* weight) {
  ForKind(view.kind,
          [&]<Kind kKind>() HWY_ATTR { WeightsAtOf<kKind>(view, normal, count, s, t, weight); });
}

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace penumbra {
namespace {

bool IsSingle(const SquareView& view) {
  return view.kind == SquareKind::kPoint || view.kind == SquareKind::kDirection;
}

}  // namespace

HWY_EXPORT(PartsBehind);
HWY_EXPORT(TargetsAt);
HWY_EXPORT(WeightsAt);

void PartsBehind(const SquareView& view, const CellGrid& grid, const Vec4* blockers, size_t count,
                 uint32_t* part) {
  const uint32_t middle = grid.along() / 2;
  if (IsSingle(view)) {
    std::fill_n(part, count, middle * grid.along() + middle);
    return;
  }
  HWY_DYNAMIC_DISPATCH(PartsBehind)(view, grid, blockers, count, part);
}

void TargetsAt(const SquareView& view, size_t count, const float* u, const float* v, float* x,
               float* y, float* z) {
  const Vec3 only = view.kind == SquareKind::kDirection ? view.n : view.origin;
  if (IsSingle(view)) {
    std::fill_n(x, count, only.x), std::fill_n(y, count, only.y), std::fill_n(z, count, only.z);
    return;
  }
  HWY_DYNAMIC_DISPATCH(TargetsAt)(view, count, u, v, x, y, z);
}

void WeightsAt(const SquareView& view, const Vec3& normal, size_t count, const float* s,
               const float* t, float* weight) {
  if (IsSingle(view)) {
    std::fill_n(weight, count, 1.0f);
    return;
  }
  HWY_DYNAMIC_DISPATCH(WeightsAt)(view, normal, count, s, t, weight);
}

}  // namespace penumbra
#endif  // HWY_ONCE
