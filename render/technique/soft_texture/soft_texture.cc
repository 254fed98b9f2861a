#include "render/technique/soft_texture/soft_texture.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "render/math/parallel_for.h"
#include "render/scene/field_error.h"
#include "render/technique/soft_texture/gl/gl_shadows.h"
#include "render/technique/soft_texture/occlusion_counter.h"
#include "render/technique/soft_texture/receiver_coverage.h"

namespace penumbra {
namespace {

// The first artifact comes after this many samples, or as many as fit into the time budget, each
// later one after this many times more.
constexpr uint32_t kFirstPassSamples = 8;
constexpr uint32_t kPassGrowth = 8;

// What of a time budget computing may take: the rest is for the way to the client.
constexpr double kComputingShare = 0.5;

// Coordinates carry 24 bits. What lies in the receiver's plane is off it by a few units in the last
// place of the largest coordinate; 32 of them are still a twentieth of a millimetre for a building
// of 30 m. A surface that is not quite flat leaves the plane by more, to either side.
double SurfaceOffset(const ReceiverPatch& receiver) {
  const Parallelogram& patch = receiver.patch;
  double largest = 0;
  for (const Vec2 uv : {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1), Vec2(1, 1)}) {
    const DVec3 corner = glm::abs(DVec3(patch.At(uv)));
    largest = std::max({largest, corner.x, corner.y, corner.z});
  }
  const double size = glm::length(DVec3(patch.edge_u)) + glm::length(DVec3(patch.edge_v));
  return std::max(std::ldexp(std::max(largest, size), -19), 2 * receiver.deviation_m);
}

// An edit whose samples, times the triangles and words of texels of each, are no more than this is
// done sooner than a coarse pass of it is sent.
constexpr uint64_t kWorkWorthAPass = 1u << 18;

// How many of `n` samples are counted in all after the pass that follows one that ended with
// `done`. A last pass that would bring less than half as many again is merged with the one before.
uint32_t NextPassEnd(uint32_t done, uint32_t first, uint32_t n) {
  if (done == 0) return std::min(first, n);
  const uint64_t count = uint64_t{done} * kPassGrowth;
  return count + count / 2 >= n ? n : static_cast<uint32_t>(count);
}

// A straight shadow edge crosses about √(2n) of the n cells of a jittered grid; the sample in each
// of these is on the dark side with some probability p, which adds p (1 − p) ≤ ¼ to the variance of
// the count.
float ErrorEstimate(uint32_t n, bool has_size) {
  if (!has_size) return 0;
  const double crossed = std::min<double>(n, std::sqrt(2.0 * n));
  return static_cast<float>(std::sqrt(0.25 * crossed) / n);
}

// What the mask says already, and would be held for as long as the artifact.
ReceiverPatch WithoutRegion(ReceiverPatch receiver) {
  receiver.region = nullptr;
  return receiver;
}

const SoftTextureParams& ParamsOf(const ArtifactSpec& spec) {
  return std::get<SoftTextureParams>(spec.params);
}

// Measures wall time from its construction; 0 without a clock.
class Stopwatch {
 public:
  explicit Stopwatch(const MonotonicClock& now_ms) : now_ms_(now_ms), start_(Now()) {}
  double ElapsedMs() const { return Now() - start_; }

 private:
  double Now() const { return now_ms_ ? now_ms_() : 0; }

  const MonotonicClock& now_ms_;
  double start_;
};

// One computation: accumulates passes and makes an artifact of each.
class Computation {
 public:
  Computation(const Scene& scene, const ArtifactSpec& spec, const ComputeContext& context,
              ReceiverPatch receiver, std::shared_ptr<const AreaLight> light)
      : spec_(spec),
        context_(context),
        watch_(context.now_ms),
        coverage_(receiver),
        receiver_(WithoutRegion(receiver)),
        light_(std::move(light)),
        surface_offset_(SurfaceOffset(receiver)),
        scene_(scene),
        plan_(Plan()),
        samples_(Samples()),
        moving_(scene, *light_, receiver_, surface_offset_, Rules(), CastersOf(true)) {
    if (plan_.base) {
      plan_.base->samples = samples_;
      moving_.CountBeyond(plan_.base->shadows);
    }
    if (ParamsOf(spec).method == VisibilityMethod::kGl) {
      on_gl_.emplace(*context.gl, scene, receiver_, surface_offset_,
                     ParamsOf(spec).radiance ? light_.get() : nullptr);
    }
    header_.scene_id = scene.id();
    header_.revision = scene.revision();
    header_.scene_hash = scene.content_hash();
    header_.technique = std::string(SoftTextureParams::kInfo.name);
    header_.light_id = spec.light_id;
    header_.receiver_id = spec.receiver_id;
    header_.samples_requested = static_cast<uint32_t>(samples_.size());
    header_.parameters = {{"samples", absl::StrCat(samples_.size())},
                          {"seed", absl::StrCat(params().seed)},
                          {"radiance", params().radiance ? "true" : "false"},
                          {"method", std::string(NameOf(params().method))},
                          {"surface_offset_m", absl::StrFormat("%.17g", surface_offset_)}};
  }

  absl::StatusOr<Artifact> Run() {
    const auto n = static_cast<uint32_t>(samples_.size());
    const uint32_t first = FirstPassSamples(n);
    for (uint32_t done = 0;; ++header_.pass) {
      const uint32_t upto = NextPassEnd(done, first, n);
      if (const auto status = Draw(done, upto); !status.ok()) return status;
      Artifact artifact = MakeArtifact(upto);
      if (context_.stop.stop_requested()) return absl::CancelledError("stop requested");
      if (FirstPassPace* const pace = Pace(); pace && done == 0) {
        pace->Learn(upto, watch_.ElapsedMs());
      }
      if (upto == n) return artifact;
      context_.progress(std::move(artifact));
      done = upto;
    }
  }

 private:
  const SoftTextureParams& params() const { return ParamsOf(spec_); }

  EditPlan Plan() const {
    if (!context_.memory || params().method == VisibilityMethod::kGl) return {};
    return PlanEdit(*context_.memory, {receiver_, *light_, params()}, scene_);
  }
  std::vector<LightSample> Samples() const {
    if (plan_.base && !plan_.base->samples.empty()) return plan_.base->samples;
    return SampleLight(*light_, params().samples, params().seed, receiver_.patch.At(Vec2(0.5f)));
  }
  ShadowRules Rules() const { return {.method = params().method}; }
  CasterChoice CastersOf(bool moving) const {
    if (!plan_.base) return {};
    return {.ids = &plan_.base->moving, .all_but_ids = !moving};
  }

  FirstPassPace* Pace() const {
    if (!context_.memory) return nullptr;
    return plan_.base ? &context_.memory->pace_of_edits : &context_.memory->pace;
  }

  uint32_t FirstPassSamples(uint32_t n) const {
    if (!context_.progress) return n;
    const uint64_t texels = uint64_t{receiver_.width} * receiver_.height;
    const bool is_all_but_done = plan_.base && plan_.base->drawn == n;
    if (is_all_but_done && n * (plan_.moving_triangles + texels / 32) <= kWorkWorthAPass) return n;
    if (spec_.time_budget_ms <= 0 || !Pace()) return kFirstPassSamples;
    return Pace()->Samples(kComputingShare * spec_.time_budget_ms, kFirstPassSamples);
  }

  // Samples [done, upto), over the base where there is one.
  absl::Status Draw(uint32_t done, uint32_t upto) {
    if (plan_.base && upto > plan_.base->drawn) {
      if (const auto status = ExtendBase(upto); !status.ok()) return status;
    }
    const auto added = std::span(samples_).subspan(done, upto - done);
    return on_gl_ ? on_gl_->Add(added, context_.stop)
                  : moving_.Add(added, context_.arena, context_.stop);
  }

  absl::Status ExtendBase(uint32_t upto) {
    ShadowBase& base = *plan_.base;
    if (!still_) {
      still_.emplace(scene_, *light_, receiver_, surface_offset_, Rules(), CastersOf(false));
      still_->StoreIn(base.shadows, base.drawn);
    }
    const auto status = still_->Add(std::span(samples_).subspan(base.drawn, upto - base.drawn),
                                    context_.arena, context_.stop);
    if (!status.ok()) return status;
    const std::vector<uint16_t> added = still_->TakeCounts();
    std::transform(added.begin(), added.end(), base.counts.begin(), base.counts.begin(),
                   std::plus<uint16_t>());
    base.drawn = upto;
    return absl::OkStatus();
  }

  std::vector<uint16_t> VisibleCounts(uint32_t done) const {
    const std::vector<uint16_t>& hidden = on_gl_ ? on_gl_->counts() : moving_.counts();
    std::vector<uint16_t> visible(hidden.size());
    const auto beyond = [done](uint16_t a, uint16_t b) {
      return static_cast<uint16_t>(done - a - b);
    };
    if (!plan_.base) {
      std::transform(hidden.begin(), hidden.end(), visible.begin(),
                     [&](uint16_t a) { return beyond(a, 0); });
    } else if (plan_.base->drawn == done) {
      std::transform(hidden.begin(), hidden.end(), plan_.base->counts.begin(), visible.begin(),
                     beyond);
    } else {
      const std::vector<uint16_t> base = plan_.base->shadows.Counts(done);
      std::transform(hidden.begin(), hidden.end(), base.begin(), visible.begin(), beyond);
    }
    coverage_.FillOutside(visible);
    return visible;
  }

  Artifact MakeArtifact(uint32_t done) {
    SoftShadowTexture texture{
        .receiver = receiver_, .light = *light_, .visibility = {}, .radiance = {}};
    texture.receiver.deviation_m = 0;
    texture.coverage = coverage_.mask();
    texture.visibility = {receiver_.width, receiver_.height, done, VisibleCounts(done)};
    if (on_gl_ && params().radiance) {
      texture.radiance = on_gl_->Radiance();
    } else if (params().radiance) {
      const Stopwatch shading(context_.now_ms);
      RunIn(context_.arena, [&] { texture.radiance = ReflectedRadiance(texture, context_.stop); });
      header_.timings_ms["shading"] = shading.ElapsedMs();
    }
    header_.light_samples.assign(samples_.begin(), samples_.begin() + done);
    for (LightSample& sample : header_.light_samples)
      sample.weight = 1.0f / static_cast<float>(done);
    header_.is_final = done == samples_.size();
    header_.error_estimate = ErrorEstimate(done, EffectiveSampleCount(*light_, 2) > 1);
    header_.timings_ms["compute"] = watch_.ElapsedMs();
    return {header_, std::move(texture)};
  }

  const ArtifactSpec& spec_;
  const ComputeContext& context_;
  Stopwatch watch_;
  ReceiverCoverage coverage_;
  ReceiverPatch receiver_;
  std::shared_ptr<const AreaLight> light_;
  double surface_offset_;
  const Scene& scene_;
  EditPlan plan_;
  std::vector<LightSample> samples_;
  // What is drawn over the base, or everything where there is none; and what of the base has to be
  // drawn.
  OcclusionCounter moving_;
  std::optional<OcclusionCounter> still_;
  std::optional<GlShadows> on_gl_;  // in place of both
  ArtifactHeader header_;
};

}  // namespace

absl::Status SoftTexture::Check(const Scene& scene, const ArtifactSpec& spec) const {
  const uint32_t samples = ParamsOf(spec).samples;
  if (samples < 1 || samples > SceneLimits{}.max_light_samples) {
    return FieldError(
        absl::StatusCode::kInvalidArgument, "RANGE", "soft_texture.samples",
        absl::StrCat("found ", samples, ", need 1 to ", SceneLimits{}.max_light_samples));
  }
  if (const auto status = CheckTimeBudget(spec); !status.ok()) return status;
  if (!scene.FindLight(spec.light_id)) {
    return FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "light_id",
                      absl::StrCat("found ", spec.light_id, ", need a light of the scene"));
  }
  return scene.ResolveReceiver(spec.receiver_id).status();
}

bool SoftTexture::NeedsGl(const ArtifactSpec& spec) const {
  return ParamsOf(spec).method == VisibilityMethod::kGl;
}

absl::StatusOr<Artifact> SoftTexture::Compute(const Scene& scene, const ArtifactSpec& spec,
                                              const ComputeContext& context) const {
  if (const auto status = Check(scene, spec); !status.ok()) return status;
  if (NeedsGl(spec) && !context.gl) {
    return FieldError(absl::StatusCode::kFailedPrecondition, "NO_GL", "soft_texture.method",
                      absl::StrCat("found gl, need an engine with an OpenGL context, or another "
                                   "method",
                                   context.gl_error.empty() ? "" : ": ", context.gl_error));
  }
  return Computation(scene, spec, context, *scene.ResolveReceiver(spec.receiver_id),
                     scene.FindLight(spec.light_id))
      .Run();
}

}  // namespace penumbra
