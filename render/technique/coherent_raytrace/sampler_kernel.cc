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

HWY_INLINE VU Mixed(VU bits, uint32_t more) {
  const U u;
  bits = hn::Xor(bits, hn::ShiftRight<16>(bits));
  bits = hn::Mul(bits, hn::Set(u, 0x7feb352du));
  bits = hn::Xor(hn::Xor(bits, hn::ShiftRight<15>(bits)), hn::Set(u, more));
  bits = hn::Mul(bits, hn::Set(u, 0x846ca68bu));
  return hn::Xor(bits, hn::ShiftRight<16>(bits));
}

HWY_INLINE VF ToShare(VU bits16) {
  return hn::Mul(hn::ConvertTo(F(), hn::BitCast(I(), bits16)), hn::Set(F(), 0x1p-16f));
}

void PlaceSamples(const CellGrid& grid, uint64_t point_seed, const SamplePlaces& places) {
  const F f;
  const I i;
  const U u;
  const VF side = hn::Set(f, 1.0f / static_cast<float>(grid.side));
  const auto parts = static_cast<float>(grid.parts);
  const auto along = static_cast<int32_t>(grid.side * grid.parts);
  for (uint32_t y = 0; y < grid.side; ++y) {
    for (uint32_t x = 0; x < grid.side; x += hn::Lanes(f)) {
      const uint32_t cell = 32 * y + x;
      const VU cells = hn::Iota(u, cell);
      const VU bits = Mixed(hn::Xor(hn::Mul(cells, hn::Set(u, 0x9e3779b1u)),
                                    hn::Set(u, static_cast<uint32_t>(point_seed))),
                            static_cast<uint32_t>(point_seed >> 32));
      const VF jitter_u = ToShare(hn::ShiftRight<16>(bits));
      const VF jitter_v = ToShare(hn::And(bits, hn::Set(u, 0xffffu)));
      const VF column = hn::Iota(f, static_cast<float>(x));
      const VF row = hn::Set(f, static_cast<float>(y));
      hn::StoreU(hn::Mul(hn::Add(column, jitter_u), side), f, places.u + cell);
      hn::StoreU(hn::Mul(hn::Add(row, jitter_v), side), f, places.v + cell);
      const auto part_x =
          hn::Add(hn::Mul(hn::ConvertTo(i, column), hn::Set(i, static_cast<int32_t>(grid.parts))),
                  hn::ConvertTo(i, hn::Mul(jitter_u, hn::Set(f, parts))));
      const auto part_y = hn::Add(hn::Set(i, static_cast<int32_t>(y * grid.parts)),
                                  hn::ConvertTo(i, hn::Mul(jitter_v, hn::Set(f, parts))));
      hn::StoreU(hn::Add(hn::Mul(part_y, hn::Set(i, along)), part_x), i, places.part + cell);
    }
  }
}

HWY_INLINE VF Dot(VF x, VF y, VF z, Vec3 v) {
  const F f;
  return hn::MulAdd(x, hn::Set(f, v.x),
                    hn::MulAdd(y, hn::Set(f, v.y), hn::Mul(z, hn::Set(f, v.z))));
}

void PartsBehind(const CellGrid& grid, const RectangleView& view, const float* x, const float* y,
                 const float* z, size_t count, int32_t* part) {
  const F f;
  const I i;
  const auto along = static_cast<float>(grid.side * grid.parts);
  const VF zero = hn::Zero(f), one = hn::Set(f, 1.0f), size = hn::Set(f, along);
  for (size_t k = 0; k < count; k += hn::Lanes(f)) {
    const VF way_x = hn::Sub(hn::LoadU(f, x + k), hn::Set(f, view.point.x));
    const VF way_y = hn::Sub(hn::LoadU(f, y + k), hn::Set(f, view.point.y));
    const VF way_z = hn::Sub(hn::LoadU(f, z + k), hn::Set(f, view.point.z));
    const VF stretch = hn::Div(hn::Set(f, view.height), Dot(way_x, way_y, way_z, view.normal));
    const VF u =
        hn::MulAdd(stretch, Dot(way_x, way_y, way_z, view.dual_u), hn::Set(f, view.along_u));
    const VF v =
        hn::MulAdd(stretch, Dot(way_x, way_y, way_z, view.dual_v), hn::Set(f, view.along_v));
    const auto is_on_light =
        hn::And(hn::Gt(stretch, one), hn::And(hn::And(hn::Ge(u, zero), hn::Lt(u, one)),
                                              hn::And(hn::Ge(v, zero), hn::Lt(v, one))));
    const auto last = hn::Set(i, static_cast<int32_t>(along) - 1);
    const auto column =
        hn::Min(hn::ConvertTo(i, hn::IfThenElseZero(is_on_light, hn::Mul(u, size))), last);
    const auto row =
        hn::Min(hn::ConvertTo(i, hn::IfThenElseZero(is_on_light, hn::Mul(v, size))), last);
    const auto at = hn::Add(hn::Mul(row, hn::Set(i, static_cast<int32_t>(along))), column);
    hn::StoreU(hn::IfThenElse(hn::RebindMask(i, is_on_light), at, hn::Set(i, -1)), i, part + k);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace penumbra {

HWY_EXPORT(PlaceSamples);
HWY_EXPORT(PartsBehind);

void PlaceSamples(const CellGrid& grid, uint64_t point_seed, const SamplePlaces& places) {
  HWY_DYNAMIC_DISPATCH(PlaceSamples)(grid, point_seed, places);
}

void PartsBehind(const CellGrid& grid, const RectangleView& view, const float* x, const float* y,
                 const float* z, size_t count, int32_t* part) {
  HWY_DYNAMIC_DISPATCH(PartsBehind)(grid, view, x, y, z, count, part);
}

}  // namespace penumbra
#endif  // HWY_ONCE
