#include "render/technique/soft_texture/soft_texture.h"

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "render/math/parallel_for.h"
#include "render/scene/field_error.h"
#include "render/technique/soft_texture/all_lights.h"
#include "render/technique/soft_texture/borrowed_outlines.h"
#include "render/technique/soft_texture/gl/gl_shadows.h"
#include "render/technique/soft_texture/occlusion_counter.h"
#include "render/technique/soft_texture/params_check.h"
#include "render/technique/soft_texture/passes.h"
#include "render/technique/soft_texture/receiver_coverage.h"
#include "render/technique/soft_texture/texture_shading.h"
#include "render/technique/stopwatch.h"

namespace penumbra {
namespace {

// What of a time budget computing may take: the rest is for the way to the client.
constexpr double kComputingShare = 0.5;

// An edit whose samples, times the triangles and words of texels of each, are no more than this is
// done sooner than a coarse pass of it is sent.
constexpr uint64_t kWorkWorthAPass = 1u << 18;

const SoftTextureParams& ParamsOf(const ArtifactSpec& spec) {
  return std::get<SoftTextureParams>(spec.params);
}

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
        moving_(scene, *light_, receiver_, surface_offset_, Rules(), CastersOf(true)),
        shading_(*light_, receiver_, surface_offset_, static_cast<uint32_t>(samples_.size()),
                 ShadingParams()) {
    if (shading_.sum()) moving_.SumInto(*shading_.sum());
    if (BorrowsOutlines(params())) {
      lenders_ = OutlineLenders(samples_, params().silhouette_reuse);
      moving_.BorrowOutlines(lenders_);
    }
    if (plan_.base) {
      plan_.base->samples = samples_;
      moving_.CountBeyond(plan_.base->shadows);
      moving_.CountWith(plan_.base->counters);
    }
    if (ParamsOf(spec).method != VisibilityMethod::kGl) {
      StartCounts();
    } else {
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
    header_.parameters = EffectiveParameters(params(), samples_.size());
    header_.parameters["surface_offset_m"] = absl::StrFormat("%.17g", surface_offset_);
  }

  absl::StatusOr<Artifact> Run() {
    const auto n = static_cast<uint32_t>(samples_.size());
    const uint32_t first = FirstPassSamples(n);
    for (uint32_t done = 0;; ++header_.pass) {
      const uint32_t upto = NextPassEnd(done, first, n);
      if (const auto status = Draw(done, upto); !status.ok()) return status;
      if (upto == n && BorrowsOutlines(params())) {
        const auto error = ErrorOfBorrowing();
        if (!error.ok()) return error.status();
        header_.parameters["silhouette_reuse_error"] = absl::StrFormat("%.3g", *error);
      }
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
  // OpenGL adds up the samples itself.
  SoftTextureParams ShadingParams() const {
    SoftTextureParams shading = params();
    if (shading.method == VisibilityMethod::kGl) shading.shading = Shading::kProduct;
    return shading;
  }
  // Where outlines are borrowed, which meshes have one must not depend on what else is drawn.
  ShadowRules Rules() const {
    return {.method = BorrowsOutlines(params()) ? VisibilityMethod::kSilhouette : params().method};
  }
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
    if (IsBaseDrawn() && n * (plan_.moving_triangles + texels / 32) <= kWorkWorthAPass) return n;
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
      still_->BorrowOutlines(lenders_);
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

  bool IsBaseDrawn() const { return plan_.base && plan_.base->drawn == samples_.size(); }

  // What moves is taken off all samples, or off what the base leaves of them if that is known
  // before the only pass.
  void StartCounts() {
    const auto n = static_cast<uint32_t>(samples_.size());
    counts_have_base_ = IsBaseDrawn() && FirstPassSamples(n) >= n;
    moving_.CountDown(counts_have_base_
                          ? plan_.base->counts
                          : std::vector<uint16_t>(size_t{receiver_.width} * receiver_.height,
                                                  static_cast<uint16_t>(n)));
  }

  // Of the first `done` samples. All of them: moving_'s counts are gone then.
  std::vector<uint16_t> VisibleCounts(uint32_t done) {
    const auto n = static_cast<uint32_t>(samples_.size());
    std::vector<uint16_t> visible = on_gl_      ? on_gl_->counts()
                                    : done == n ? moving_.TakeCounts()
                                                : moving_.counts();
    if (on_gl_) {
      for (uint16_t& count : visible) count = static_cast<uint16_t>(done - count);
    } else if (plan_.base && !counts_have_base_) {
      if (plan_.base->drawn == done) {
        std::transform(visible.begin(), visible.end(), plan_.base->counts.begin(), visible.begin(),
                       [n](uint16_t a, uint16_t b) { return static_cast<uint16_t>(a + b - n); });
      } else {
        plan_.base->shadows.SubtractFrom(visible, done);
      }
    }
    if (!on_gl_ && done < n) {
      for (uint16_t& count : visible) count = static_cast<uint16_t>(count + done - n);
    }
    coverage_.FillOutside(visible);
    return visible;
  }

  // At most the sum of what goes wrong with what moves and with what stays, which is told once.
  absl::StatusOr<double> ErrorOfBorrowing() {
    if (!plan_.base) return ErrorOfBorrowing({});
    std::optional<double>& still = plan_.base->borrowing_error;
    if (!still) {
      const auto error = ErrorOfBorrowing(CastersOf(false));
      if (!error.ok()) return error;
      still = *error;
    }
    const auto moving = ErrorOfBorrowing(CastersOf(true));
    return moving.ok() ? std::min(1.0, *still + *moving) : moving;
  }

  absl::StatusOr<double> ErrorOfBorrowing(const CasterChoice& casters) {
    OcclusionCounter exact(scene_, *light_, receiver_, surface_offset_, Rules(), casters);
    OcclusionCounter borrowing(scene_, *light_, receiver_, surface_offset_, Rules(), casters);
    return BorrowingError(exact, borrowing, samples_, lenders_, coverage_.mask().get(), receiver_,
                          context_.arena, context_.stop);
  }

  Artifact MakeArtifact(uint32_t done) {
    SoftShadowTexture texture{
        .receiver = receiver_, .light = *light_, .visibility = {}, .radiance = {}};
    texture.receiver.deviation_m = 0;
    texture.coverage = coverage_.mask();
    texture.visibility = {receiver_.width, receiver_.height, done, VisibleCounts(done)};
    texture.count_bits = BitsOf(params().count_bits);
    if (params().radiance) {
      const Stopwatch shading(context_.now_ms);
      RunIn(context_.arena, [&] {
        texture.radiance = on_gl_ ? shading_.Finish(on_gl_->Radiance(), texture, context_.stop)
                                  : shading_.Shade(texture, context_.stop);
      });
      header_.timings_ms["shading"] = shading.ElapsedMs();
      if (IsUnorm(texture.radiance->format)) {
        header_.parameters["output_scale"] = absl::StrFormat("%.9g", texture.radiance->scale);
      }
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
  std::vector<LightSample> samples_, lenders_;  // lenders: where outlines are borrowed
  // What is drawn over the base, or everything where there is none; and what of the base has to be
  // drawn.
  OcclusionCounter moving_;
  std::optional<OcclusionCounter> still_;
  bool counts_have_base_ = false;   // those of moving_
  std::optional<GlShadows> on_gl_;  // in place of both
  TextureShading shading_;
  ArtifactHeader header_;
};

}  // namespace

absl::Status SoftTexture::Check(const Scene& scene, const ArtifactSpec& spec) const {
  return CheckSpec(scene, spec);
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
  if (spec.light_id == kAllLights) return ComputeAllLights(*this, scene, spec, context);
  return Computation(scene, spec, context, *scene.ResolveReceiver(spec.receiver_id),
                     scene.FindLight(spec.light_id))
      .Run();
}

}  // namespace penumbra
