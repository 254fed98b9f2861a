// Walking over clusters of edges, compiled once for each instruction set.

#if defined(PENUMBRA_SILHOUETTE_CLUSTERS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PENUMBRA_SILHOUETTE_CLUSTERS_INL_H_
#undef PENUMBRA_SILHOUETTE_CLUSTERS_INL_H_
#else
#define PENUMBRA_SILHOUETTE_CLUSTERS_INL_H_
#endif

#include <cstdint>
#include <span>
#include <vector>

#include "hwy/highway.h"
#include "render/scene/silhouette_kernel.h"
#include "render/scene/silhouette_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

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

// Calls `visit` with the number of every cluster of edges that may have faces of both facings, seen
// from somewhere within `radius` of the viewpoint.
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

// Which edges of one vector can be on the outline seen from somewhere within `radius` of the
// viewpoint.
HWY_INLINE auto Sometimes(const EdgeCluster& edges, size_t lane, const View& view, float radius) {
  const auto left = HeightOver(LoadPlanes(edges.left, lane), view);
  const auto right = HeightOver(LoadPlanes(edges.right, lane), view);
  const auto reach = hn::Set(F(), radius);
  return hn::Not(
      hn::Or(hn::Gt(hn::Min(left, right), reach), hn::Lt(hn::Max(left, right), hn::Neg(reach))));
}

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#endif  // toggled for each target
