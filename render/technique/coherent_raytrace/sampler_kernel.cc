#include "render/technique/coherent_raytrace/sampler_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/technique/coherent_raytrace/sampler_kernel.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each target
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, kSamplerLanes>;
using I = hn::RebindToSigned<F>;
using U = hn::RebindToUnsigned<F>;
using VF = hn::Vec<F>;
using VU = hn::Vec<U>;

HWY_INLINE VU Mixed(VU bits, VU more) {
  const U u;
  bits = hn::Xor(bits, hn::ShiftRight<16>(bits));
  bits = hn::Mul(bits, hn::Set(u, 0x7feb352du));
  bits = hn::Xor(hn::Xor(bits, hn::ShiftRight<15>(bits)), more);
  bits = hn::Mul(bits, hn::Set(u, 0x846ca68bu));
  return hn::Xor(bits, hn::ShiftRight<16>(bits));
}

HWY_INLINE VF ToShare(VU bits16) {
  return hn::Mul(hn::ConvertTo(F(), hn::BitCast(I(), bits16)), hn::Set(F(), 0x1p-16f));
}

void PlaceSamples(const CellGrid& grid, uint64_t sample_seed, const uint32_t* cell, size_t count,
                  const SamplePlaces& places) {
  const F f;
  const I i;
  const U u;
  const VF side = hn::Set(f, 1.0f / static_cast<float>(grid.side));
  const VF parts = hn::Set(f, static_cast<float>(grid.parts));
  const auto parts_in_cell = hn::Set(u, grid.parts), along = hn::Set(u, grid.along());
  const VU seed_low = hn::Set(u, static_cast<uint32_t>(sample_seed));
  const VU seed_high = hn::Set(u, static_cast<uint32_t>(sample_seed >> 32));
  for (size_t k = 0; k < count; k += hn::Lanes(f)) {
    const VU cells = hn::LoadU(u, cell + k);
    const VU bits = Mixed(hn::Xor(hn::Mul(cells, hn::Set(u, 0x9e3779b1u)), seed_low), seed_high);
    const VF jitter_u = ToShare(hn::ShiftRight<16>(bits));
    const VF jitter_v = ToShare(hn::And(bits, hn::Set(u, 0xffffu)));
    const VF column = hn::ConvertTo(f, hn::BitCast(i, hn::And(cells, hn::Set(u, 31u))));
    const VF row = hn::ConvertTo(f, hn::BitCast(i, hn::ShiftRight<5>(cells)));
    hn::StoreU(hn::Mul(hn::Add(column, jitter_u), side), f, places.u + k);
    hn::StoreU(hn::Mul(hn::Add(row, jitter_v), side), f, places.v + k);
    const auto part_x = hn::BitCast(u, hn::ConvertTo(i, hn::Mul(jitter_u, parts)));
    const auto part_y = hn::BitCast(u, hn::ConvertTo(i, hn::Mul(jitter_v, parts)));
    const auto columns = hn::Add(hn::Mul(hn::And(cells, hn::Set(u, 31u)), parts_in_cell), part_x);
    const auto rows = hn::Add(hn::Mul(hn::ShiftRight<5>(cells), parts_in_cell), part_y);
    hn::StoreU(hn::Add(hn::Mul(rows, along), columns), u, places.part + k);
  }
}

HWY_INLINE VF Dot(VF x, VF y, VF z, Vec3 v) {
  const F f;
  return hn::MulAdd(x, hn::Set(f, v.x),
                    hn::MulAdd(y, hn::Set(f, v.y), hn::Mul(z, hn::Set(f, v.z))));
}

void PartsBehind(const CellGrid& grid, const RectangleView& view, const Vec4* blockers,
                 size_t count, uint32_t* part) {
  const F f;
  const I i;
  const VF zero = hn::Zero(f), one = hn::Set(f, 1.0f);
  const auto along = hn::Set(i, static_cast<int32_t>(grid.along()));
  const auto last = hn::Set(i, static_cast<int32_t>(grid.along()) - 1);
  const auto off = hn::Set(i, static_cast<int32_t>(grid.off()));
  const VF size = hn::Set(f, static_cast<float>(grid.along()));
  for (size_t k = 0; k < count; k += hn::Lanes(f)) {
    VF x, y, z, unused;
    hn::LoadInterleaved4(f, &blockers[k].x, x, y, z, unused);
    const VF way_x = hn::Sub(x, hn::Set(f, view.point.x));
    const VF way_y = hn::Sub(y, hn::Set(f, view.point.y));
    const VF way_z = hn::Sub(z, hn::Set(f, view.point.z));
    const VF stretch = hn::Div(hn::Set(f, view.height), Dot(way_x, way_y, way_z, view.normal));
    const VF u =
        hn::MulAdd(stretch, Dot(way_x, way_y, way_z, view.dual_u), hn::Set(f, view.along_u));
    const VF v =
        hn::MulAdd(stretch, Dot(way_x, way_y, way_z, view.dual_v), hn::Set(f, view.along_v));
    const auto is_on_light =
        hn::And(hn::Gt(stretch, one), hn::And(hn::And(hn::Ge(u, zero), hn::Lt(u, one)),
                                              hn::And(hn::Ge(v, zero), hn::Lt(v, one))));
    const auto column =
        hn::Min(hn::ConvertTo(i, hn::IfThenElseZero(is_on_light, hn::Mul(u, size))), last);
    const auto row =
        hn::Min(hn::ConvertTo(i, hn::IfThenElseZero(is_on_light, hn::Mul(v, size))), last);
    const auto at =
        hn::IfThenElse(hn::RebindMask(i, is_on_light), hn::Add(hn::Mul(row, along), column), off);
    const hn::RebindToUnsigned<I> unsigned_lanes;
    hn::StoreU(hn::BitCast(unsigned_lanes, at), unsigned_lanes, part + k);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace penumbra {

HWY_EXPORT(PlaceSamples);
HWY_EXPORT(PartsBehind);

void PlaceSamples(const CellGrid& grid, uint64_t sample_seed, const uint32_t* cell, size_t count,
                  const SamplePlaces& places) {
  HWY_DYNAMIC_DISPATCH(PlaceSamples)(grid, sample_seed, cell, count, places);
}

void PartsBehind(const CellGrid& grid, const RectangleView& view, const Vec4* blockers,
                 size_t count, uint32_t* part) {
  HWY_DYNAMIC_DISPATCH(PartsBehind)(grid, view, blockers, count, part);
}

}  // namespace penumbra
#endif  // HWY_ONCE
