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
  const size_t count = blockers_end_ - blockers_begin_;
  Vec4* const blockers = blockers_.data() + blockers_begin_;
  seen_.PartsBehind(grid_, blockers, count, part_.data());
  blockers_begin_ = blockers_end_ - parts.KeepLast({part_.data(), count}, blockers);
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
    ForgetBlockers();
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
    ForgetBlockers();
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
  const size_t count = rays.blocked_at.size();
  MakeRoom(count);
  Vec4* next = blockers_.data() + blockers_end_;
  const Vec3 from = square_.is_at_infinity() ? Vec3(0.0f) : previous_;
  for (size_t i = 0; i < count; ++i) {
    const Vec3 way = Vec3(rays.x[i], rays.y[i], rays.z[i]) - from;
    *next = Vec4(previous_ + rays.blocked_at[i] * way, 0.0f);
    next += rays.blocked_at[i] != kUnblocked;
  }
  blockers_end_ = static_cast<size_t>(next - blockers_.data());
}

// Of as many blockers more, behind the last.
inline void CoherentSampler::MakeRoom(size_t more) {
  const size_t needed = blockers_end_ + more + kSamplerLanes;
  if (needed <= blockers_.size()) return;
  // Once in many points: what is kept moves up by what is not at each of them.
  std::copy(blockers_.begin() + blockers_begin_, blockers_.begin() + blockers_end_,
            blockers_.begin());
  blockers_end_ -= blockers_begin_;
  blockers_begin_ = 0;
  blockers_.resize(std::max(blockers_.size(), kSpareBlockers + 2 * (blockers_end_ + more)));
}

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
