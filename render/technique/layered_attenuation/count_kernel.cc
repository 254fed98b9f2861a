#include "render/technique/layered_attenuation/count_kernel.h"

#include "render/artifact/plane_on_image.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/technique/layered_attenuation/count_kernel.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each target
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, kLayerLanes>;
using I = hn::RebindToSigned<F>;
using VF = hn::Vec<F>;
using VI = hn::Vec<I>;
using Mask = hn::Mask<F>;

HWY_INLINE VF All(float value) { return hn::Set(F(), value); }

// As many layers as there are lanes.
struct SomeLayers {
  VF x, y, nearness, gradient_x, gradient_y;

  SomeLayers(const LayerArrays& l, size_t k)
      : x(hn::LoadU(F(), l.x + k)),
        y(hn::LoadU(F(), l.y + k)),
        nearness(hn::LoadU(F(), l.nearness + k)),
        gradient_x(hn::LoadU(F(), l.gradient_x + k)),
        gradient_y(hn::LoadU(F(), l.gradient_y + k)) {}
};

// ViewWarp::ToView(); kAhead: where the eye has moved along the depth.
template <bool kAhead>
HWY_INLINE SomeLayers ToView(const ViewWarp& warp, const SomeLayers& l) {
  const VF one = All(1.0f), move_x = All(warp.move.x), move_y = All(warp.move.y);
  SomeLayers there = l;
  VF turn = hn::NegMulAdd(l.gradient_x, move_x, hn::NegMulAdd(l.gradient_y, move_y, one));
  there.x = hn::NegMulAdd(move_x, l.nearness, l.x);
  there.y = hn::NegMulAdd(move_y, l.nearness, l.y);
  if constexpr (kAhead) {
    const VF ahead = All(warp.ahead);
    const VF shrink = hn::Div(one, hn::NegMulAdd(ahead, l.nearness, one));
    there.x = hn::Mul(there.x, shrink);
    there.y = hn::Mul(there.y, shrink);
    there.nearness = hn::Mul(l.nearness, shrink);
    const VF at_zero =
        hn::NegMulAdd(l.gradient_x, l.x, hn::NegMulAdd(l.gradient_y, l.y, l.nearness));
    turn = hn::NegMulAdd(ahead, at_zero, turn);
  }
  const VF grow = hn::Div(one, turn);
  there.gradient_x = hn::Mul(l.gradient_x, grow);
  there.gradient_y = hn::Mul(l.gradient_y, grow);
  return there;
}

HWY_INLINE VF Cut(VF slope, VF limit) { return hn::Max(hn::Neg(limit), hn::Min(slope, limit)); }

// Neighbours in a row mostly fall on neighbours in a row. `first` is the first lane's pixel, where
// all lanes' follow each other; −1: they do not.
HWY_INLINE int32_t FirstOfRun(VI pixel, Mask is_inside) {
  const I i;
  const int32_t first = hn::GetLane(pixel);
  const auto is_run = hn::Eq(pixel, hn::Add(hn::Set(i, first), hn::Iota(i, 0)));
  return hn::AllTrue(i, hn::And(is_run, hn::RebindMask(i, is_inside))) ? first : -1;
}

// Others may write the same at the same time.
HWY_INLINE void Mark(uint8_t* place) { __atomic_store_n(place, uint8_t{1}, __ATOMIC_RELAXED); }

// Lanes that match nothing write past the map's end: that is quicker than to leave them out.
HWY_INLINE void MarkExplained(VI pixel, int32_t run, Mask is_matched, const LookupMap& map) {
  const I i;
  if (run >= 0 && hn::AllTrue(F(), is_matched)) {
    for (size_t lane = 0; lane < hn::Lanes(i); ++lane) Mark(map.explained + run + lane);
    return;
  }
  HWY_ALIGN int32_t places[kLayerLanes];
  const VI end = hn::Set(i, map.width * map.height);
  hn::Store(hn::IfThenElse(hn::RebindMask(i, is_matched), pixel, end), i, places);
  for (size_t lane = 0; lane < hn::Lanes(i); ++lane) Mark(map.explained + places[lane]);
}

// 1 in the lanes of the layers that the map does not hide, 0 in the others.
template <bool kAhead>
HWY_INLINE VI Visible(const SomeLayers& layers, const LookupMap& map,
                      const LayerTolerance& tolerance) {
  const F f;
  const I i;
  const SomeLayers there = ToView<kAhead>(map.warp, layers);
  const VF x = hn::Add(there.x, All(map.warp.view_origin.x));
  const VF y = hn::Add(there.y, All(map.warp.view_origin.y));
  const VF zero = hn::Zero(f);
  Mask is_inside =
      hn::And(hn::And(hn::Ge(x, zero), hn::Lt(x, All(static_cast<float>(map.width)))),
              hn::And(hn::Ge(y, zero), hn::Lt(y, All(static_cast<float>(map.height)))));
  if constexpr (kAhead) is_inside = hn::And(is_inside, hn::Gt(there.nearness, zero));
  const VI column = hn::ConvertTo(i, hn::IfThenElseZero(is_inside, x));
  const VI row = hn::ConvertTo(i, hn::IfThenElseZero(is_inside, y));
  const VI pixel = hn::Add(hn::Mul(row, hn::Set(i, map.width)), column);
  const int32_t run = FirstOfRun(pixel, is_inside);
  const VF seen =
      run >= 0 ? hn::LoadU(f, map.nearness + run) : hn::GatherIndex(f, map.nearness, pixel);

  const VF width =
      map.from_infinity ? All(tolerance.width) : hn::Mul(All(tolerance.width), there.nearness);
  const VF steepest = hn::Mul(All(static_cast<float>(kMaxSteepness)), width);
  const VF gradient_x = Cut(there.gradient_x, steepest);
  const VF gradient_y = Cut(there.gradient_y, steepest);
  const VF half = All(0.5f);
  const VF dx = hn::Sub(hn::Add(hn::ConvertTo(f, column), half), x);
  const VF dy = hn::Sub(hn::Add(hn::ConvertTo(f, row), half), y);
  const VF expected = hn::MulAdd(gradient_x, dx, hn::MulAdd(gradient_y, dy, there.nearness));
  // By the view that sees less from its edge: by the other much would pass that hides the layer.
  const VF steepness = hn::Min(hn::Add(hn::Abs(layers.gradient_x), hn::Abs(layers.gradient_y)),
                               hn::Add(hn::Abs(gradient_x), hn::Abs(gradient_y)));
  const VF slack = hn::Mul(All(tolerance.pixels), hn::Add(width, steepness));
  const VF nearer = hn::Sub(seen, expected);
  const Mask is_hidden = hn::And(is_inside, hn::Gt(nearer, slack));
  if (map.explained) {
    const Mask is_matched = hn::And(is_inside, hn::Le(hn::Abs(nearer), slack));
    MarkExplained(pixel, run, is_matched, map);
  }
  return hn::IfThenZeroElse(hn::RebindMask(i, is_hidden), hn::Set(i, 1));
}

void CountVisible(const LayerArrays& layers, std::span<const LookupMap> maps,
                  const LayerTolerance& tolerance) {
  const I i;
  const hn::Rebind<uint16_t, F> u16;
  for (size_t k = 0; k < layers.size; k += hn::Lanes(F())) {
    const SomeLayers some(layers, k);
    VI visible = hn::Zero(i);
    for (const LookupMap& map : maps) {
      visible = hn::Add(visible, map.warp.ahead == 0 ? Visible<false>(some, map, tolerance)
                                                     : Visible<true>(some, map, tolerance));
    }
    hn::StoreU(hn::Add(hn::LoadU(u16, layers.count + k), hn::DemoteTo(u16, visible)), u16,
               layers.count + k);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace penumbra {

HWY_EXPORT(CountVisible);

void CountVisible(const LayerArrays& layers, std::span<const LookupMap> maps,
                  const LayerTolerance& tolerance) {
  HWY_DYNAMIC_DISPATCH(CountVisible)(layers, maps, tolerance);
}

}  // namespace penumbra
#endif  // HWY_ONCE
