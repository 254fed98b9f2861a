#include "render/scene/silhouette_kernel.h"

#include <algorithm>

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

// The end of a list, in registers while edges are appended: what is stored through a pointer could
// be a list's own, as far as the compiler knows.
class Appender {
 public:
  Appender(SilhouetteList& list, size_t room) {
    list.Reserve(room);
    from_ = list.from.data();
    to_ = list.to.data();
    weight_ = list.weight.data();
    count_ = list.count;
  }

  // Appends the lanes of `found`, which are `bits`, of a vector of edges with the facing of their
  // left faces.
  template <class M>
  HWY_INLINE void Append(const EdgeCluster& edges, size_t lane, M found, uint32_t bits, M left) {
    const I i;
    const U u;
    const auto in_u = hn::RebindMask(u, found);
    const auto weight = hn::IfThenElse(hn::RebindMask(i, left), hn::Set(i, 2), hn::Set(i, -2));
    StorePacked(u, hn::Load(u, edges.from + lane), in_u, bits, from_ + count_);
    StorePacked(u, hn::Load(u, edges.to + lane), in_u, bits, to_ + count_);
    StorePacked(i, weight, hn::RebindMask(i, found), bits, weight_ + count_);
    count_ += static_cast<size_t>(__builtin_popcount(bits));
  }

  size_t count() const { return count_; }

 private:
  uint32_t *from_, *to_;
  int32_t* weight_;
  size_t count_;
};

// Appends the edges of one vector whose faces differ in facing. `kRare`: asks first whether there is
// one; where often there is, no branch predictor knows when.
template <bool kRare>
HWY_INLINE void SelectVector(const EdgeCluster& edges, size_t lane, const View& view,
                             Appender& to) {
  const F f;
  const auto left = InFront(LoadPlanes(edges.left, lane), view);
  const auto right = InFront(LoadPlanes(edges.right, lane), view);
  const auto found = hn::MaskFromVec(hn::Xor(hn::VecFromMask(f, left), hn::VecFromMask(f, right)));
  const uint32_t bits = BitsOf(found);
  if (kRare && bits == 0) return;
  to.Append(edges, lane, found, bits, left);
}

void SelectSharedEdges(std::span<const EdgeCluster> edges, const float (&viewpoint)[4],
                       SilhouetteList& list) {
  const View view(viewpoint);
  Appender to(list, edges.size() * kClusterEdges);
  for (const EdgeCluster& cluster : edges) {
    for (size_t k = 0; k < kClusterEdges; k += hn::Lanes(F())) {
      SelectVector<true>(cluster, k, view, to);
    }
  }
  list.count = to.count();
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

HWY_INLINE void Prefetch(const EdgeCluster& cluster) {
  const auto* bytes = reinterpret_cast<const char*>(&cluster);
  for (size_t line = 0; line < sizeof cluster; line += 64) __builtin_prefetch(bytes + line);
}

// Calls `visit` with the number of every cluster of edges that may have faces of both facings, seen from
// somewhere within `radius` of the viewpoint.
template <class Visit>
HWY_INLINE void ForEachUndecided(std::span<const EdgeCluster> edges,
                                 std::span<const ClusterLevel> levels, const float (&viewpoint)[4],
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
    if (pending.level == 0 && pending.bits != 0) {
      Prefetch(edges[pending.first + static_cast<uint32_t>(__builtin_ctz(pending.bits))]);
    }
    if (pending.level == 0) {
      visit(size_t{cluster});
    } else {
      stack[depth++] = look(pending.level - 1, size_t{cluster} * kClusterEdges);
    }
  }
}

// Calls `visit` with the number of every cluster, but for those that lie apart in `levels`.
template <class Visit>
HWY_INLINE void ForEachCluster(std::span<const EdgeCluster> edges,
                               std::span<const ClusterLevel> levels, const float (&viewpoint)[4],
                               float radius, const Visit& visit) {
  if (!levels.empty()) return ForEachUndecided(edges, levels, viewpoint, radius, visit);
  for (size_t c = 0; c < edges.size(); ++c) visit(c);
}

void SelectByClusters(std::span<const EdgeCluster> edges, std::span<const ClusterLevel> levels,
                      const float (&viewpoint)[4], SilhouetteList& list) {
  const View view(viewpoint);
  ForEachUndecided(edges, levels, viewpoint, 0, [&](size_t c) HWY_ATTR {
    Appender to(list, kClusterEdges);
    for (size_t k = 0; k < kClusterEdges; k += hn::Lanes(F())) {
      SelectVector<true>(edges[c], k, view, to);
    }
    list.count = to.count();
  });
}

// Which edges of one vector can be on the outline seen from somewhere within `radius` of the
// viewpoint.
HWY_INLINE auto Sometimes(const EdgeCluster& edges, size_t lane, const View& view, float radius) {
  const auto left = HeightOver(LoadPlanes(edges.left, lane), view);
  const auto right = HeightOver(LoadPlanes(edges.right, lane), view);
  const auto reach = hn::Set(F(), radius);
  return hn::Not(
      hn::Or(hn::Gt(hn::Min(left, right), reach), hn::Lt(hn::Max(left, right), hn::Neg(reach))));
}

void SelectForEach(std::span<const EdgeCluster> edges, std::span<const ClusterLevel> levels,
                   const ViewGroup& group, std::span<SilhouetteList> lists) {
  const size_t lanes = hn::Lanes(F());
  // Vectors that some viewpoint may see an edge of, to be looked at by one viewpoint after the
  // other: as many as stay in the first cache.
  struct Vector {
    const EdgeCluster* cluster;
    size_t lane;
  };
  constexpr size_t kMost = 32;
  Vector vectors[kMost];
  size_t size = 0;
  const View middle(group.center);
  const auto look_at_them = [&]() HWY_ATTR {
    for (size_t v = 0; v < group.count; ++v) {
      const View view(group.viewpoints[v]);
      Appender to(lists[v], size * lanes);
      for (size_t k = 0; k < size; ++k) {
        SelectVector<false>(*vectors[k].cluster, vectors[k].lane, view, to);
      }
      lists[v].count = to.count();
    }
    size = 0;
  };
  ForEachCluster(edges, levels, group.center, group.radius, [&](size_t c) HWY_ATTR {
    for (size_t k = 0; k < kClusterEdges; k += lanes) {
      vectors[size] = {&edges[c], k};
      if (BitsOf(Sometimes(edges[c], k, middle, group.radius)) != 0) ++size;
      if (size == kMost) look_at_them();
    }
  });
  look_at_them();
}

size_t CopySometimes(std::span<const EdgeCluster> edges, size_t count,
                     std::span<const ClusterLevel> levels, const float (&viewpoint)[4],
                     float radius, std::vector<EdgeCluster>& copies) {
  const F f;
  const U u;
  const View view(viewpoint);
  // Edges that do not make a cluster yet. A vector that is added may reach into a second one.
  constexpr size_t kRoom = 2 * kClusterEdges;
  alignas(64) uint32_t vertices[2][kRoom] = {};
  alignas(64) float planes[8][kRoom] = {};
  size_t size = 0;
  const auto end_cluster = [&] {
    EdgeCluster& cluster = copies.emplace_back();
    uint32_t* const vertex_arrays[2] = {cluster.from, cluster.to};
    float* const plane_arrays[8] = {cluster.left.x,      cluster.left.y,      cluster.left.z,
                                    cluster.left.offset, cluster.right.x,     cluster.right.y,
                                    cluster.right.z,     cluster.right.offset};
    const auto move = [](auto& from, auto* to) {
      std::copy_n(from, kClusterEdges, to);
      std::copy_n(from + kClusterEdges, kClusterEdges, from);
    };
    for (size_t a = 0; a < 2; ++a) move(vertices[a], vertex_arrays[a]);
    for (size_t a = 0; a < 8; ++a) move(planes[a], plane_arrays[a]);
  };
  ForEachCluster(edges, levels, viewpoint, radius, [&](size_t c) HWY_ATTR {
    const EdgeCluster& cluster = edges[c];
    for (size_t k = 0; k < kClusterEdges; k += hn::Lanes(f)) {
      const size_t e = c * kClusterEdges + k;
      if (e >= count) break;
      const auto sometimes = hn::And(Sometimes(cluster, k, view, radius), hn::FirstN(f, count - e));
      const uint32_t bits = BitsOf(sometimes);
      if (bits == 0) continue;
      const auto in_u = hn::RebindMask(u, sometimes);
      StorePacked(u, hn::Load(u, cluster.from + k), in_u, bits, vertices[0] + size);
      StorePacked(u, hn::Load(u, cluster.to + k), in_u, bits, vertices[1] + size);
      const Planes left = LoadPlanes(cluster.left, k), right = LoadPlanes(cluster.right, k);
      StorePacked(f, left.x, sometimes, bits, planes[0] + size);
      StorePacked(f, left.y, sometimes, bits, planes[1] + size);
      StorePacked(f, left.z, sometimes, bits, planes[2] + size);
      StorePacked(f, left.offset, sometimes, bits, planes[3] + size);
      StorePacked(f, right.x, sometimes, bits, planes[4] + size);
      StorePacked(f, right.y, sometimes, bits, planes[5] + size);
      StorePacked(f, right.z, sometimes, bits, planes[6] + size);
      StorePacked(f, right.offset, sometimes, bits, planes[7] + size);
      size += static_cast<size_t>(__builtin_popcount(bits));
      if (size < kClusterEdges) continue;
      end_cluster();
      size -= kClusterEdges;
    }
  });
  const size_t copied = copies.size() * kClusterEdges + size;
  for (auto& array : vertices) std::fill(array + size, std::end(array), 0u);
  for (auto& array : planes) std::fill(array + size, std::end(array), 0.0f);
  if (size > 0) end_cluster();
  return copied;
}

void AppendBorderEdges(std::span<const BorderCluster> edges, size_t count,
                       const float (&viewpoint)[4], SilhouetteList& list) {
  const F f;
  const I i;
  const U u;
  const View view(viewpoint);
  list.Reserve(edges.size() * kClusterEdges);
  size_t place = list.count;
  for (const BorderCluster& cluster : edges) {
    for (size_t k = 0; k < kClusterEdges; k += hn::Lanes(f), place += hn::Lanes(f)) {
      const auto in_front = hn::RebindMask(i, InFront(LoadPlanes(cluster.left, k), view));
      hn::StoreU(hn::Load(u, cluster.from + k), u, list.from.data() + place);
      hn::StoreU(hn::Load(u, cluster.to + k), u, list.to.data() + place);
      hn::StoreU(hn::IfThenElse(in_front, hn::Set(i, 1), hn::Set(i, -1)), i,
                 list.weight.data() + place);
    }
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
HWY_EXPORT(SelectForEach);
HWY_EXPORT(CopySometimes);
HWY_EXPORT(AppendBorderEdges);

void SelectSharedEdges(std::span<const EdgeCluster> edges, const float (&viewpoint)[4],
                       SilhouetteList& list) {
  HWY_DYNAMIC_DISPATCH(SelectSharedEdges)(edges, viewpoint, list);
}

void SelectByClusters(std::span<const EdgeCluster> edges, std::span<const ClusterLevel> levels,
                      const float (&viewpoint)[4], SilhouetteList& list) {
  HWY_DYNAMIC_DISPATCH(SelectByClusters)(edges, levels, viewpoint, list);
}

void SelectForEach(std::span<const EdgeCluster> edges, std::span<const ClusterLevel> levels,
                   const ViewGroup& group, std::span<SilhouetteList> lists) {
  HWY_DYNAMIC_DISPATCH(SelectForEach)(edges, levels, group, lists);
}

size_t CopySometimes(std::span<const EdgeCluster> edges, size_t count,
                     std::span<const ClusterLevel> levels, const float (&viewpoint)[4],
                     float radius, std::vector<EdgeCluster>& copies) {
  return HWY_DYNAMIC_DISPATCH(CopySometimes)(edges, count, levels, viewpoint, radius, copies);
}

void AppendBorderEdges(std::span<const BorderCluster> edges, size_t count,
                       const float (&viewpoint)[4], SilhouetteList& list) {
  HWY_DYNAMIC_DISPATCH(AppendBorderEdges)(edges, count, viewpoint, list);
}

}  // namespace penumbra
#endif  // HWY_ONCE
