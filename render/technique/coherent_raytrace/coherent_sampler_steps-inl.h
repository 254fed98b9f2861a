// What CoherentSampler does at a point; compiled once for each instruction set.

#if defined(PENUMBRA_COHERENT_SAMPLER_STEPS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PENUMBRA_COHERENT_SAMPLER_STEPS_INL_H_
#undef PENUMBRA_COHERENT_SAMPLER_STEPS_INL_H_
#else
#define PENUMBRA_COHERENT_SAMPLER_STEPS_INL_H_
#endif

#include <array>

#include "hwy/highway.h"
#include "render/technique/coherent_raytrace/coherent_sampler-inl.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

inline CellMask CoherentSampler::Predict(PartTable& parts) {
  if (part_.size() < blockers_.size()) part_.resize(blockers_.size());
  seen_.PartsBehind(grid_, blockers_.data(), blocker_count_, part_.data());
  blocker_count_ = parts.KeepLast({part_.data(), blocker_count_}, blockers_.data());
  return parts.Cells(settings_.side);
}

inline CellMask CoherentSampler::KnownByBlockers(const CellMask& cells,
                                                 const PartTable& parts) const {
  SampleBatch samples;
  samples.Add(cells, grid_, sample_seed_);
  CellMask known(settings_.side);
  for (size_t i = 0; i < samples.count; ++i) {
    const uint32_t cell = samples.cell[i];
    known.AddIf(parts.HasBlocker(samples.part[i]), cell);
  }
  return known;
}

inline CellMask CoherentSampler::Below(const Vec3& normal) const {
  switch (seen_.SideOf(normal)) {
    case LightSquare::Seen::Side::kAbove:
      return CellMask(settings_.side);
    case LightSquare::Seen::Side::kBelow:
      return all_;
    case LightSquare::Seen::Side::kBoth:
      break;
  }
  SampleBatch samples;
  samples.Add(all_, grid_, sample_seed_);
  std::array<float, SampleBatch::kMax + kSamplerLanes> x, y, z;
  seen_.TargetsAt(samples.count, samples.u.data(), samples.v.data(), x.data(), y.data(), z.data());
  CellMask below(settings_.side);
  for (size_t i = 0; i < samples.count; ++i) {
    below.AddIf(!seen_.IsAbove({x[i], y[i], z[i]}, normal), samples.cell[i]);
  }
  return below;
}

inline void CoherentSampler::Begin(const SurfacePoint& point, uint64_t point_index,
                                   const CellMask& lit, SamplerTables& tables) {
  todo_ = below_ = predicted_ = blocked_ = CellMask(settings_.side);
  if (square_.IsDarkAt(point.position)) {
    has_previous_ = false;
    blocked_ = all_;
    return;
  }
  const bool uses_prediction = settings_.predicts && IsNear(point);
  previous_ = point.position, has_previous_ = true;
  if (lit == all_) {
    // No blocker hides any of it: they are forgotten as if each had been projected.
    blocker_count_ = 0;
    unknown_ = CellMask(settings_.side);
    return;
  }
  seen_ = square_.From(point.position);
  sample_seed_ = SampleSeed(settings_.seed, point_index);
  below_ = Below(point.normal);
  const CellMask open = all_ - lit - below_;
  if (uses_prediction) {
    blocked_ = Predict(tables.parts) - lit;
    todo_ = open & (blocked_.Boundary() | tables.exterior[turn_] | unknown_);
    turn_ = turn_ + 1 < settings_.exterior_turns ? turn_ + 1 : 0;
  } else {
    blocker_count_ = 0;
    todo_ = open;
  }
  predicted_ = open - todo_;
  if (settings_.skips_known_rays && uses_prediction) {
    todo_ -= KnownByBlockers(todo_ & blocked_, tables.parts);
  }
  unknown_ = below_;
}

inline void CoherentSampler::Take(const TracedRays& rays) {
  CellMask hit(settings_.side);
  for (size_t i = 0; i < rays.cell.size(); ++i) {
    hit.AddIf(rays.blocked_at[i] != kUnblocked, rays.cell[i]);
  }
  if (settings_.predicts) AddBlockers(rays);
  const CellMask wrong = (hit - blocked_) | ((blocked_ & todo_) - hit);
  blocked_ = (blocked_ - todo_) | hit;
  todo_ = wrong.Dilated() & predicted_;
  predicted_ -= todo_;
}

inline void CoherentSampler::AddBlockers(const TracedRays& rays) {
  const size_t most = blocker_count_ + rays.cell.size() + kSamplerLanes;
  if (blockers_.size() < most) blockers_.resize(2 * most);
  Vec4* const blockers = blockers_.data();
  size_t count = blocker_count_;
  for (size_t i = 0; i < rays.cell.size(); ++i) {
    const Vec3 target(rays.x[i], rays.y[i], rays.z[i]);
    const Vec3 way = square_.is_at_infinity() ? target : target - previous_;
    blockers[count] = Vec4(previous_ + rays.blocked_at[i] * way, 0.0f);
    count += rays.blocked_at[i] != kUnblocked;
  }
  blocker_count_ = count;
}

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
