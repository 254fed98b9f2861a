// What telling outlines apart is made of, compiled once for each instruction set.

#if defined(PENUMBRA_SILHOUETTE_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PENUMBRA_SILHOUETTE_LANES_INL_H_
#undef PENUMBRA_SILHOUETTE_LANES_INL_H_
#else
#define PENUMBRA_SILHOUETTE_LANES_INL_H_
#endif

#include <cstdint>
#include <span>

#include "hwy/highway.h"
#include "render/scene/silhouette_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, kClusterEdges>;
using I = hn::RebindToSigned<F>;
using U = hn::RebindToUnsigned<F>;

// The planes of one vector of faces.
struct Planes {
  hn::Vec<F> x, y, z, offset;
};

HWY_INLINE Planes LoadPlanes(const FacePlanes& planes, size_t lane) {
  const F f;
  return {hn::Load(f, planes.x + lane), hn::Load(f, planes.y + lane), hn::Load(f, planes.z + lane),
          hn::Load(f, planes.offset + lane)};
}

// A viewpoint in every lane.
struct View {
  hn::Vec<F> x, y, z, minus_w;

  explicit HWY_INLINE View(const float (&v)[4])
      : x(hn::Set(F(), v[0])),
        y(hn::Set(F(), v[1])),
        z(hn::Set(F(), v[2])),
        minus_w(hn::Set(F(), -v[3])) {}
};

// Every face is asked about with the same operations in the same order, whichever edge asks.
HWY_INLINE hn::Vec<F> HeightOver(const Planes& planes, const View& view) {
  auto height = hn::Mul(planes.offset, view.minus_w);
  height = hn::MulAdd(planes.z, view.z, height);
  height = hn::MulAdd(planes.y, view.y, height);
  return hn::MulAdd(planes.x, view.x, height);
}

HWY_INLINE auto InFront(const Planes& planes, const View& view) {
  return hn::Gt(HeightOver(planes, view), hn::Zero(F()));
}

// Lanes as bits of a number.
template <class M>
HWY_INLINE uint32_t BitsOf(M mask) {
  uint8_t bytes[8] = {};
  hn::StoreMaskBits(F(), mask, bytes);
  return bytes[0] | uint32_t{bytes[1]} << 8;
}

#if HWY_TARGET == HWY_AVX2
// For every choice of eight lanes, those that are chosen, one after another.
struct ChosenLanes {
  uint8_t of[256][8];

  constexpr ChosenLanes() : of() {
    for (uint32_t bits = 0; bits < 256; ++bits) {
      for (uint8_t lane = 0, count = 0; lane < 8; ++lane) {
        if ((bits >> lane & 1) != 0) of[bits][count++] = lane;
      }
    }
  }
};
constexpr ChosenLanes kChosenLanes;
#endif

// Puts the lanes of `mask`, which are `bits`, one after another at `to`, which has room for a whole
// vector. (Storing them directly, compressed, takes a hundred cycles on some processors, and for
// AVX2 Highway's Compress copies a table of 1 KB to the stack each time.)
template <class D, class V, class M, typename T>
HWY_INLINE void StorePacked(D d, V v, M mask, uint32_t bits, T* to) {
#if HWY_TARGET == HWY_AVX2
  (void)mask;
  const hn::Rebind<uint8_t, D> u8;
  const auto lanes = hn::PromoteTo(hn::RebindToSigned<D>(), hn::LoadU(u8, kChosenLanes.of[bits]));
  hn::StoreU(hn::TableLookupLanes(v, hn::IndicesFromVec(d, lanes)), d, to);
#else
  (void)bits;
  hn::StoreU(hn::Compress(v, mask), d, to);
#endif
}

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#endif  // toggled for each target
