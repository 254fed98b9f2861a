#include "render/scene/silhouette_kernel.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/scene/silhouette_kernel.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each target
#include "hwy/highway.h"
#include "render/scene/silhouette_clusters-inl.h"
#include "render/scene/silhouette_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

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

// Appends the edges of one vector whose faces differ in facing. `kRare`: asks first whether there
// is one; where often there is, no branch predictor knows when.
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

// Edges put one after another, of which the last do not make a cluster yet.
struct PendingEdges {
  // A vector that is added may reach into a second cluster.
  static constexpr size_t kRoom = 2 * kClusterEdges;
  alignas(64) uint32_t vertices[2][kRoom] = {};
  alignas(64) float planes[8][kRoom] = {};
  size_t size = 0;

  template <class M>
  HWY_INLINE void Add(const EdgeCluster& cluster, size_t lane, M chosen, uint32_t bits) {
    const F f;
    const U u;
    const auto in_u = hn::RebindMask(u, chosen);
    StorePacked(u, hn::Load(u, cluster.from + lane), in_u, bits, vertices[0] + size);
    StorePacked(u, hn::Load(u, cluster.to + lane), in_u, bits, vertices[1] + size);
    const Planes left = LoadPlanes(cluster.left, lane), right = LoadPlanes(cluster.right, lane);
    StorePacked(f, left.x, chosen, bits, planes[0] + size);
    StorePacked(f, left.y, chosen, bits, planes[1] + size);
    StorePacked(f, left.z, chosen, bits, planes[2] + size);
    StorePacked(f, left.offset, chosen, bits, planes[3] + size);
    StorePacked(f, right.x, chosen, bits, planes[4] + size);
    StorePacked(f, right.y, chosen, bits, planes[5] + size);
    StorePacked(f, right.z, chosen, bits, planes[6] + size);
    StorePacked(f, right.offset, chosen, bits, planes[7] + size);
    size += static_cast<size_t>(__builtin_popcount(bits));
  }

  // Moves the first cluster's to `copies`.
  void EndCluster(std::vector<EdgeCluster>& copies) {
    EdgeCluster& cluster = copies.emplace_back();
    uint32_t* const vertices_to[2] = {cluster.from, cluster.to};
    FacePlanes &left = cluster.left, &right = cluster.right;
    float* const planes_to[8] = {left.x,  left.y,  left.z,  left.offset,
                                 right.x, right.y, right.z, right.offset};
    const auto move = [](auto& from, auto* to) {
      std::copy_n(from, kClusterEdges, to);
      std::copy_n(from + kClusterEdges, kClusterEdges, from);
    };
    for (size_t a = 0; a < 2; ++a) move(vertices[a], vertices_to[a]);
    for (size_t a = 0; a < 8; ++a) move(planes[a], planes_to[a]);
    size -= std::min(size, kClusterEdges);
  }

  // Zeros from the last edge on: nobody is in front of them.
  void Pad() {
    for (auto& array : vertices) std::fill(array + size, std::end(array), 0u);
    for (auto& array : planes) std::fill(array + size, std::end(array), 0.0f);
  }
};

size_t CopySometimes(std::span<const EdgeCluster> edges, size_t count,
                     std::span<const ClusterLevel> levels, const float (&viewpoint)[4],
                     float radius, std::vector<EdgeCluster>& copies) {
  const F f;
  const View view(viewpoint);
  copies.reserve(edges.size() / 4);  // most often enough: outlines are small
  PendingEdges pending;
  ForEachCluster(edges, levels, viewpoint, radius, [&](size_t c) HWY_ATTR {
    for (size_t k = 0; k < kClusterEdges; k += hn::Lanes(f)) {
      const size_t e = c * kClusterEdges + k;
      if (e >= count) break;
      const auto sometimes =
          hn::And(Sometimes(edges[c], k, view, radius), hn::FirstN(f, count - e));
      const uint32_t bits = BitsOf(sometimes);
      if (bits == 0) continue;
      pending.Add(edges[c], k, sometimes, bits);
      if (pending.size >= kClusterEdges) pending.EndCluster(copies);
    }
  });
  const size_t copied = copies.size() * kClusterEdges + pending.size;
  pending.Pad();
  if (pending.size > 0) pending.EndCluster(copies);
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
HWY_EXPORT(SelectForEach);
HWY_EXPORT(CopySometimes);
HWY_EXPORT(AppendBorderEdges);

void SelectSharedEdges(std::span<const EdgeCluster> edges, const float (&viewpoint)[4],
                       SilhouetteList& list) {
  HWY_DYNAMIC_DISPATCH(SelectSharedEdges)(edges, viewpoint, list);
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
