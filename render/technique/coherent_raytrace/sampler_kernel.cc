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

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace penumbra {

HWY_EXPORT(PlaceSamples);

void PlaceSamples(const CellGrid& grid, uint64_t sample_seed, const uint32_t* cell, size_t count,
                  const SamplePlaces& places) {
  HWY_DYNAMIC_DISPATCH(PlaceSamples)(grid, sample_seed, cell, count, places);
}

}  // namespace penumbra
#endif  // HWY_ONCE
