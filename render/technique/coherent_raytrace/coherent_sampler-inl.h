// How much of a light each of many neighbouring points sees, by tracing shadow rays only where that
// is likely to change from one point to the next; compiled once for each instruction set.
//
//   sampler.Begin(point, index, lit, tables);
//   while (!sampler.todo().empty()) sampler.Take(…);  // what the rays of these cells met
//   const CellMask visible = sampler.visible();

#if defined(PENUMBRA_COHERENT_SAMPLER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PENUMBRA_COHERENT_SAMPLER_INL_H_
#undef PENUMBRA_COHERENT_SAMPLER_INL_H_
#else
#define PENUMBRA_COHERENT_SAMPLER_INL_H_
#endif

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "hwy/highway.h"
#include "render/scene/point_receiver.h"
#include "render/technique/coherent_raytrace/cell_mask.h"
#include "render/technique/coherent_raytrace/light_square.h"
#include "render/technique/coherent_raytrace/part_table-inl.h"
#include "render/technique/coherent_raytrace/point_samples.h"
#include "render/technique/coherent_raytrace/sampling_settings.h"
#include "render/technique/coherent_raytrace/shadow_tracer.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

// A sampler's rays, by the cells that they go to, and where they were blocked.
struct TracedRays {
  std::span<const uint32_t> cell;
  std::span<const float> x, y, z, blocked_at;
};

// One point after another, each predicted from the one before.
//
// Source  Agrawala et al. 2000, §5.2; departs: (1) cells to do are traced together and wrong ones
//         spread afterwards, which reaches the same cells as a queue; (2) a point all of whose
//         light was seen leaves no blockers, and all of the light is then predicted to be seen,
//         where the pseudocode would trace every cell; (3) of a cell's neighbours the four that
//         share an edge count, not eight: 15 % of the rays less; (4) cells at the light's edge are
//         not all traced at every point (SamplingSettings::exterior_turns); (5) a point that is far
//         from the one before can continue from another (ContinueFrom)
class CoherentSampler {
 public:
  CoherentSampler(const LightSquare& square, const SamplingSettings& settings);

  // Forgets the points before.
  void Restart();
  // Whether what is known would say something of the point.
  bool IsNear(const SurfacePoint& point) const;
  // As if the other's points had been this one's.
  void ContinueFrom(const CoherentSampler& other);

  // Samples behind the surface's plane, or on a light whose back it is turned to, are not seen and
  // cost nothing.
  //
  // lit  cells that are known to be seen
  void Begin(const SurfacePoint& point, uint64_t point_index, const CellMask& lit,
             SamplerTables& tables);
  // The cells whose rays are to be traced next; none when the point is done.
  const CellMask& todo() const { return todo_; }
  // What became of the rays of todo().
  void Take(const TracedRays& rays);
  // The cells whose samples the point sees.
  CellMask visible() const { return all_ - blocked_ - below_; }
  bool has_blockers() const { return blockers_end_ > blockers_begin_; }

  const LightSquare::Seen& seen() const { return seen_; }
  uint64_t sample_seed() const { return sample_seed_; }

 private:
  // Room for what is added until what is left out is moved over.
  static constexpr size_t kSpareBlockers = 4096;

  void AddBlockers(const TracedRays& rays);
  void MakeRoom(size_t more);
  void ForgetBlockers() { blockers_begin_ = blockers_end_ = 0; }
  // The cells that blockers hide. Keeps the newest blocker of each part.
  CellMask Predict(PartTable& parts);
  // Of the cells, those with a blocker in the part that their sample is in.
  CellMask KnownByBlockers(const CellMask& cells, const PartTable& parts) const;
  CellMask Below(const Vec3& normal) const;

  const LightSquare& square_;
  const SamplingSettings settings_;
  const CellGrid grid_;
  const CellMask all_;

  // Of the point at hand.
  LightSquare::Seen seen_;
  uint64_t sample_seed_ = 0;
  CellMask below_;  // the surface's plane
  CellMask blocked_;
  CellMask todo_;
  CellMask predicted_;  // neither known nor traced

  bool has_previous_ = false;
  Vec3 previous_{0.0f};  // or, once it has begun, the point at hand
  CellMask unknown_;  // cells of which the point before told nothing that holds for its neighbours
  // Those from begin to end; padded; their last coordinates say nothing.
  std::vector<Vec4> blockers_;
  size_t blockers_begin_ = 0, blockers_end_ = 0;
  std::vector<uint32_t> part_;  // that each blocker hides
  uint32_t turn_ = 0;
};

inline CoherentSampler::CoherentSampler(const LightSquare& square, const SamplingSettings& settings)
    : square_(square),
      settings_(settings),
      grid_{settings.side, settings.parts},
      all_(CellMask::All(settings.side)),
      seen_(square.From(Vec3(0.0f))) {
  Restart();
}

inline void CoherentSampler::Restart() {
  has_previous_ = false;
  turn_ = 0;
  ForgetBlockers();
  todo_ = blocked_ = below_ = predicted_ = unknown_ = CellMask(settings_.side);
}

inline bool CoherentSampler::IsNear(const SurfacePoint& point) const {
  const Vec3 way = point.position - previous_;
  return has_previous_ &&
         glm::dot(way, way) <= settings_.prediction_distance * settings_.prediction_distance;
}

inline void CoherentSampler::ContinueFrom(const CoherentSampler& other) {
  has_previous_ = other.has_previous_;
  previous_ = other.previous_;
  unknown_ = other.unknown_;
  ForgetBlockers();
  const size_t count = other.blockers_end_ - other.blockers_begin_;
  MakeRoom(count);
  std::copy_n(other.blockers_.begin() + other.blockers_begin_, count, blockers_.begin());
  blockers_end_ = count;
  turn_ = other.turn_;
}

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
