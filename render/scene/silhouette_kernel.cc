#include "render/scene/silhouette_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/scene/silhouette_kernel.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each target
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, kClusterEdges>;
using I = hn::RebindToSigned<F>;
using U = hn::RebindToUnsigned<F>;

// Every face is asked about with the same operations in the same order, whichever edge asks.
HWY_INLINE auto HeightOver(const FacePlanes& planes, size_t i, const float (&v)[4]) {
  const F f;
  auto height = hn::Mul(hn::LoadU(f, planes.offset.data() + i), hn::Set(f, -v[3]));
  height = hn::MulAdd(hn::LoadU(f, planes.z.data() + i), hn::Set(f, v[2]), height);
  height = hn::MulAdd(hn::LoadU(f, planes.y.data() + i), hn::Set(f, v[1]), height);
  height = hn::MulAdd(hn::LoadU(f, planes.x.data() + i), hn::Set(f, v[0]), height);
  return height;
}

HWY_INLINE auto InFront(const FacePlanes& planes, size_t i, const float (&v)[4]) {
  return hn::Gt(HeightOver(planes, i, v), hn::Zero(F()));
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

// Appends the edges of one vector that are among the first `valid` lanes.
HWY_INLINE void SelectVector(const EdgeArrays& edges, size_t e, size_t valid, const float (&v)[4],
                             SilhouetteList& list) {
  const F f;
  const I i;
  const U u;
  const auto left = hn::VecFromMask(f, InFront(edges.left, e, v));
  const auto right = hn::VecFromMask(f, InFront(edges.right, e, v));
  const auto found = hn::And(hn::MaskFromVec(hn::Xor(left, right)), hn::FirstN(f, valid));
  const uint32_t bits = BitsOf(found);
  if (bits == 0) return;
  const auto in_u = hn::RebindMask(u, found);
  const auto weight =
      hn::IfThenElse(hn::RebindMask(i, hn::MaskFromVec(left)), hn::Set(i, 2), hn::Set(i, -2));
  StorePacked(u, hn::LoadU(u, edges.from.data() + e), in_u, bits, list.from.data() + list.count);
  StorePacked(u, hn::LoadU(u, edges.to.data() + e), in_u, bits, list.to.data() + list.count);
  StorePacked(i, weight, hn::RebindMask(i, found), bits, list.weight.data() + list.count);
  list.count += static_cast<size_t>(__builtin_popcount(bits));
}

void SelectSharedEdges(const EdgeArrays& edges, size_t first, size_t count,
                       const float (&viewpoint)[4], SilhouetteList& list) {
  list.Reserve(count);
  for (size_t e = 0; e < count; e += hn::Lanes(F())) {
    SelectVector(edges, first + e, count - e, viewpoint, list);
  }
}

// Which of sixteen clusters may have faces of both facings, as bits. With v from a ball's centre to
// the viewpoint, a face's height over its plane is least where its normal leans as far away from v
// as the cone lets it: |v| cos(φ + θ), less the radius.
HWY_INLINE uint32_t Undecided(const ClusterLevel& c, size_t first, const float (&viewpoint)[4],
                              float ball_radius) {
  const F f;
  uint32_t bits = 0;
  const auto w = hn::Set(f, viewpoint[3]);
  for (size_t k = 0; k < kClusterEdges; k += hn::Lanes(f)) {
    const size_t at = first + k;
    const auto load = [&](const std::vector<float>& values)
                          HWY_ATTR { return hn::LoadU(f, values.data() + at); };
    const auto x = hn::NegMulAdd(w, load(c.x), hn::Set(f, viewpoint[0]));
    const auto y = hn::NegMulAdd(w, load(c.y), hn::Set(f, viewpoint[1]));
    const auto z = hn::NegMulAdd(w, load(c.z), hn::Set(f, viewpoint[2]));
    const auto square = hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z)));
    const auto along =
        hn::MulAdd(x, load(c.axis_x), hn::MulAdd(y, load(c.axis_y), hn::Mul(z, load(c.axis_z))));
    const auto across = hn::Sqrt(hn::Max(hn::NegMulAdd(along, along, square), hn::Zero(f)));
    const auto least =
        hn::NegMulAdd(across, load(c.sin_spread), hn::Mul(hn::Abs(along), load(c.cos_spread)));
    const auto slack =
        hn::MulAdd(hn::Sqrt(square), hn::Set(f, kFacingSlack), hn::Set(f, ball_radius));
    const auto reach = hn::MulAdd(load(c.radius), w, slack);
    const auto is_narrow = hn::Gt(load(c.cos_spread), hn::Zero(f));
    const auto undecided = hn::Not(hn::And(is_narrow, hn::Gt(least, reach)));
    bits |= BitsOf(undecided) << k;
  }
  const size_t clusters = c.count - first;  // past these there is padding
  return clusters < kClusterEdges ? bits & ((1u << clusters) - 1) : bits;
}

// Calls `visit` with the first edge of every cluster that may have faces of both facings, seen from
// somewhere within `radius` of the viewpoint.
template <class Visit>
HWY_INLINE void ForEachUndecided(std::span<const ClusterLevel> levels, const float (&viewpoint)[4],
                                 float radius, const Visit& visit) {
  if (levels.empty()) return;
  struct Pending {
    uint32_t level, first, bits;  // of the sixteen clusters from `first` on, those to look into
  };
  Pending stack[16];  // 16^16 edges
  const auto look = [&](size_t level, size_t first) HWY_ATTR {
    return Pending{static_cast<uint32_t>(level), static_cast<uint32_t>(first),
                   Undecided(levels[level], first, viewpoint, radius)};
  };
  stack[0] = look(levels.size() - 1, 0);
  for (size_t depth = 1; depth > 0;) {
    Pending& pending = stack[depth - 1];
    if (pending.bits == 0) {
      --depth;
      continue;
    }
    const uint32_t cluster = pending.first + static_cast<uint32_t>(__builtin_ctz(pending.bits));
    pending.bits &= pending.bits - 1;
    const size_t inside = size_t{cluster} * kClusterEdges;
    if (pending.level == 0) {
      visit(inside);
    } else {
      stack[depth++] = look(pending.level - 1, inside);
    }
  }
}

void SelectByClusters(const EdgeArrays& edges, std::span<const ClusterLevel> levels,
                      const float (&viewpoint)[4], SilhouetteList& list) {
  ForEachUndecided(levels, viewpoint, 0, [&](size_t first) HWY_ATTR {
    list.Reserve(kClusterEdges);
    for (size_t k = 0; k < kClusterEdges; k += hn::Lanes(F())) {
      SelectVector(edges, first + k, kClusterEdges, viewpoint, list);
    }
  });
}

void SelectSometimes(const EdgeArrays& edges, size_t count, std::span<const ClusterLevel> levels,
                     const float (&viewpoint)[4], float radius, std::vector<uint32_t>& found) {
  const F f;
  const U u;
  size_t size = found.size();
  const auto reach = hn::Set(f, radius);
  const auto below = hn::Neg(reach);
  const auto look_into = [&](size_t first) HWY_ATTR {
    if (found.size() < size + 2 * kClusterEdges) found.resize(2 * size + 64 * kClusterEdges);
    for (size_t k = 0; k < kClusterEdges; k += hn::Lanes(f)) {
      const size_t e = first + k;
      if (e >= count) break;
      const auto left = HeightOver(edges.left, e, viewpoint);
      const auto right = HeightOver(edges.right, e, viewpoint);
      const auto decided =
          hn::Or(hn::Gt(hn::Min(left, right), reach), hn::Lt(hn::Max(left, right), below));
      const auto sometimes = hn::AndNot(decided, hn::FirstN(f, count - e));
      const uint32_t bits = BitsOf(sometimes);
      StorePacked(u, hn::Iota(u, static_cast<uint32_t>(e)), hn::RebindMask(u, sometimes), bits,
                  found.data() + size);
      size += static_cast<size_t>(__builtin_popcount(bits));
    }
  };
  if (levels.empty()) {
    for (size_t first = 0; first < count; first += kClusterEdges) look_into(first);
  } else {
    ForEachUndecided(levels, viewpoint, radius, look_into);
  }
  found.resize(size);
}

void AppendBorderEdges(const EdgeArrays& edges, size_t count, const float (&viewpoint)[4],
                       SilhouetteList& list) {
  const F f;
  const I i;
  const U u;
  list.Reserve(count);
  for (size_t e = 0; e < count; e += hn::Lanes(f)) {
    const auto in_front = hn::RebindMask(i, InFront(edges.left, e, viewpoint));
    const size_t place = list.count + e;
    hn::StoreU(hn::LoadU(u, edges.from.data() + e), u, list.from.data() + place);
    hn::StoreU(hn::LoadU(u, edges.to.data() + e), u, list.to.data() + place);
    hn::StoreU(hn::IfThenElse(in_front, hn::Set(i, 1), hn::Set(i, -1)), i,
               list.weight.data() + place);
  }
  list.count += count;
}

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace penumbra {

HWY_EXPORT(SelectSharedEdges);
HWY_EXPORT(SelectByClusters);
HWY_EXPORT(SelectSometimes);
HWY_EXPORT(AppendBorderEdges);

void SelectSharedEdges(const EdgeArrays& edges, size_t first, size_t count,
                       const float (&viewpoint)[4], SilhouetteList& list) {
  HWY_DYNAMIC_DISPATCH(SelectSharedEdges)(edges, first, count, viewpoint, list);
}

void SelectByClusters(const EdgeArrays& edges, std::span<const ClusterLevel> levels,
                      const float (&viewpoint)[4], SilhouetteList& list) {
  HWY_DYNAMIC_DISPATCH(SelectByClusters)(edges, levels, viewpoint, list);
}

void SelectSometimes(const EdgeArrays& edges, size_t count, std::span<const ClusterLevel> levels,
                     const float (&viewpoint)[4], float radius, std::vector<uint32_t>& found) {
  HWY_DYNAMIC_DISPATCH(SelectSometimes)(edges, count, levels, viewpoint, radius, found);
}

void AppendBorderEdges(const EdgeArrays& edges, size_t count, const float (&viewpoint)[4],
                       SilhouetteList& list) {
  HWY_DYNAMIC_DISPATCH(AppendBorderEdges)(edges, count, viewpoint, list);
}

}  // namespace penumbra
#endif  // HWY_ONCE
