#include "render/technique/coherent_raytrace/sampler_front.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/technique/coherent_raytrace/sampler_front.cc"
#include <array>
#include <cassert>
#include <utility>
#include <vector>

#include "hwy/foreach_target.h"  // compiles this file once for each target
#include "hwy/highway.h"
#include "render/technique/coherent_raytrace/coherent_sampler_steps-inl.h"
#include "render/technique/coherent_raytrace/light_proof.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

class Front final : public SamplerFront {
 public:
  Front(const LightSquare& square, const ShadowTracer& tracer, const SamplingSettings& settings,
        const LightProof* proof);

  void Restart() override;
  void Begin(uint32_t lane, const SurfacePoint& point, uint64_t point_index) override;
  void Finish() override;

  CellMask visible(uint32_t lane) const override { return samplers_[lane].visible(); }
  uint32_t rays(uint32_t lane) const override { return rays_[lane]; }
  TraceCounts TakeCounts() override { return std::exchange(counts_, {}); }

 private:
  void AskForRays(uint32_t lane);
  void TraceBatch();
  void PlaceTargets();

  const LightSquare& square_;
  const ShadowTracer& tracer_;
  const SamplingSettings settings_;
  const LightProof* const proof_;
  const CellGrid grid_;
  TraceCounts counts_;
  std::vector<CoherentSampler> samplers_;
  SamplerTables tables_;
  std::array<SurfacePoint, kLanes> points_;
  std::array<uint32_t, kLanes> rays_{};
  std::vector<uint32_t> begun_;  // lanes
  std::vector<uint32_t> open_;   // of these, those with something to do

  // Rays to be traced together.
  SampleBatch samples_;
  std::vector<RayFan> fans_;
  std::vector<uint32_t> fan_lanes_;
  std::array<float, SampleBatch::kMax + kSamplerLanes> x_, y_, z_, blocked_at_;
};

// Of a light without extent one ray is all there is to know.
inline SamplingSettings SettingsFor(const LightSquare& square, SamplingSettings settings) {
  settings.predicts = settings.predicts && !square.is_single();
  return settings;
}

Front::Front(const LightSquare& square, const ShadowTracer& tracer,
             const SamplingSettings& settings, const LightProof* proof)
    : square_(square),
      tracer_(tracer),
      settings_(SettingsFor(square, settings)),
      proof_(proof),
      grid_{settings.side, settings.parts},
      samplers_(kLanes, CoherentSampler(square, settings_)),
      tables_(settings_) {}

void Front::Restart() {
  for (CoherentSampler& sampler : samplers_) sampler.Restart();
  begun_.clear();
}

void Front::Begin(uint32_t lane, const SurfacePoint& point, uint64_t point_index) {
  assert(begun_.empty() || begun_.back() > lane);
  CoherentSampler& sampler = samplers_[lane];
  if (!sampler.IsNear(point) && lane > 0 && samplers_[lane - 1].IsNear(point)) {
    sampler.ContinueFrom(samplers_[lane - 1]);
  }
  // Where something was in the way of the point before a proof would be in vain.
  const bool may_be_lit = !sampler.has_blockers() || !sampler.IsNear(point);
  sampler.Begin(
      point, point_index,
      proof_ && may_be_lit ? proof_->LitFrom(point, settings_.side) : CellMask(settings_.side),
      tables_);
  points_[lane] = point;
  rays_[lane] = 0;
  begun_.push_back(lane);
}

void Front::Finish() {
  open_ = std::exchange(begun_, {});
  for (;;) {
    std::erase_if(open_, [&](uint32_t lane) { return samplers_[lane].todo().empty(); });
    if (open_.empty()) break;
    for (const uint32_t lane : open_) AskForRays(lane);
    TraceBatch();
  }
}

void Front::AskForRays(uint32_t lane) {
  const CoherentSampler& sampler = samplers_[lane];
  if (samples_.count + sampler.todo().Count() > SampleBatch::kMax) TraceBatch();
  const size_t first = samples_.count;
  samples_.Add(sampler.todo(), grid_, sampler.sample_seed());
  rays_[lane] += samples_.count - first;
  fans_.push_back({points_[lane], samples_.count});
  fan_lanes_.push_back(lane);
}

void Front::TraceBatch() {
  PlaceTargets();
  const size_t n = samples_.count;
  tracer_.Trace({.fans = fans_,
                 .at_infinity = square_.is_at_infinity(),
                 .wants_blockers = settings_.predicts,
                 .x = {x_.data(), n},
                 .y = {y_.data(), n},
                 .z = {z_.data(), n}},
                {blocked_at_.data(), n}, counts_);
  size_t first = 0;
  for (size_t f = 0; f < fans_.size(); ++f) {
    const size_t count = fans_[f].end - first;
    samplers_[fan_lanes_[f]].Take({.cell = {&samples_.cell[first], count},
                                   .x = {&x_[first], count},
                                   .y = {&y_[first], count},
                                   .z = {&z_[first], count},
                                   .blocked_at = {&blocked_at_[first], count}});
    first = fans_[f].end;
  }
  samples_.count = 0;
  fans_.clear();
  fan_lanes_.clear();
}

void Front::PlaceTargets() {
  const auto place = [&](const CoherentSampler& sampler, size_t first, size_t end) {
    sampler.seen().TargetsAt(end - first, &samples_.u[first], &samples_.v[first], &x_[first],
                             &y_[first], &z_[first]);
  };
  // Of a sphere each point sees another disc.
  if (square_.kind() != LightSquare::Kind::kSphere) {
    return place(samplers_[0], 0, samples_.count);
  }
  size_t first = 0;
  for (size_t f = 0; f < fans_.size(); ++f) {
    place(samplers_[fan_lanes_[f]], first, fans_[f].end);
    first = fans_[f].end;
  }
}

std::unique_ptr<SamplerFront> MakeFront(const LightSquare& square, const ShadowTracer& tracer,
                                        const SamplingSettings& settings, const LightProof* proof) {
  return std::make_unique<Front>(square, tracer, settings, proof);
}

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace penumbra {

HWY_EXPORT(MakeFront);

std::unique_ptr<SamplerFront> MakeSamplerFront(const LightSquare& square,
                                               const ShadowTracer& tracer,
                                               const SamplingSettings& settings,
                                               const LightProof* proof) {
  return HWY_DYNAMIC_DISPATCH(MakeFront)(square, tracer, settings, proof);
}

}  // namespace penumbra
#endif  // HWY_ONCE
