#include "render/technique/soft_texture/texture_passes.h"

#include <algorithm>
#include <functional>
#include <string>
#include <utility>

#include "absl/strings/str_format.h"
#include "render/math/float_text.h"
#include "render/math/parallel_for.h"
#include "render/technique/passes.h"
#include "render/technique/soft_texture/params_check.h"
#include "render/technique/spec_check.h"

namespace penumbra {
namespace {

// An edit whose samples, times the triangles and words of texels of each, are no more than this is
// done sooner than a coarse pass of it is sent.
constexpr uint64_t kWorkWorthAPass = 1u << 18;

}  // namespace

TexturePasses::TexturePasses(const Scene& scene, const ArtifactSpec& spec,
                             const ComputeContext& context)
    : TexturePasses(scene, spec, context, *scene.ResolveReceiver(spec.receiver_id)) {}

TexturePasses::TexturePasses(const Scene& scene, const ArtifactSpec& spec,
                             const ComputeContext& context, const ReceiverPatch& receiver)
    : spec_(spec),
      context_(context),
      watch_(context.now_ms),
      coverage_(receiver),
      receiver_(WithoutRegion(receiver)),
      light_(scene.FindLight(spec.light_id)),
      surface_offset_(SurfaceOffset(receiver)),
      scene_(scene),
      plan_(Plan()),
      samples_(Samples()),
      moving_(scene, *light_, receiver_, surface_offset_, Rules(), CastersOf(true)),
      shading_(*light_, receiver_, surface_offset_, sample_count(), ShadingParams()) {
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
  if (params().method != VisibilityMethod::kGl) {
    StartCounts();
  } else {
    on_gl_.emplace(*context.gl, scene, receiver_, surface_offset_,
                   params().radiance ? light_.get() : nullptr);
  }
  FillHeader();
}

void TexturePasses::FillHeader() {
  header_ = HeaderOf(scene_, spec_);
  header_.samples_requested = sample_count();
  header_.parameters = EffectiveParameters(params(), samples_.size());
  header_.parameters["surface_offset_m"] = absl::StrFormat("%.17g", surface_offset_);
}

absl::StatusOr<Artifact> TexturePasses::Next() {
  if (done_ > 0) return Advance(NextPassEnd(done_, 0, sample_count()));
  auto artifact = Advance(NextPassEnd(0, FirstPassSamples(), sample_count()));
  if (FirstPassPace* const pace = Pace(); pace && artifact.ok()) pace->Learn(done_, compute_ms_);
  return artifact;
}

absl::StatusOr<Artifact> TexturePasses::Last() { return Advance(sample_count()); }

absl::StatusOr<Artifact> TexturePasses::Advance(uint32_t upto) {
  if (done_ > 0) watch_.Restart();
  if (const auto status = Draw(upto); !status.ok()) return status;
  done_ = upto;
  if (upto == sample_count() && BorrowsOutlines(params())) {
    const auto error = ErrorOfBorrowing();
    if (!error.ok()) return error.status();
    header_.parameters["silhouette_reuse_error"] = absl::StrFormat("%.3g", *error);
  }
  Artifact artifact = MakeArtifact();
  if (context_.stop.stop_requested()) return absl::CancelledError("stop requested");
  ++header_.pass;
  compute_ms_ += watch_.ElapsedMs();
  return artifact;
}

EditPlan TexturePasses::Plan() const {
  if (!context_.memory || params().method == VisibilityMethod::kGl) return {};
  return PlanEdit(*context_.memory, {receiver_, *light_, params()}, scene_);
}

std::vector<LightSample> TexturePasses::Samples() const {
  if (plan_.base && !plan_.base->samples.empty()) return plan_.base->samples;
  return SampleLight(*light_, params().samples, params().seed, receiver_.patch.At(Vec2(0.5f)));
}

// OpenGL adds up the samples itself.
SoftTextureParams TexturePasses::ShadingParams() const {
  SoftTextureParams shading = params();
  if (shading.method == VisibilityMethod::kGl) shading.shading = Shading::kProduct;
  return shading;
}

// Where outlines are borrowed, which meshes have one must not depend on what else is drawn.
ShadowRules TexturePasses::Rules() const {
  return {.method = BorrowsOutlines(params()) ? VisibilityMethod::kSilhouette : params().method};
}

CasterChoice TexturePasses::CastersOf(bool moving) const {
  if (!plan_.base) return {};
  return {.ids = &plan_.base->moving, .all_but_ids = !moving};
}

FirstPassPace* TexturePasses::Pace() const {
  if (!context_.memory) return nullptr;
  return plan_.base ? &context_.memory->pace_of_edits : &context_.memory->pace;
}

bool TexturePasses::IsBaseDrawn() const {
  return plan_.base && plan_.base->drawn == samples_.size();
}

uint32_t TexturePasses::FirstPassSamples() const {
  const uint32_t n = sample_count();
  if (!context_.progress) return n;
  const uint64_t texels = uint64_t{receiver_.width} * receiver_.height;
  if (IsBaseDrawn() && n * (plan_.moving_triangles + texels / 32) <= kWorkWorthAPass) return n;
  return penumbra::FirstPassSamples(spec_.time_budget_ms, Pace());
}

// The samples up to `upto`, over the base where there is one.
absl::Status TexturePasses::Draw(uint32_t upto) {
  if (plan_.base && upto > plan_.base->drawn) {
    if (const auto status = ExtendBase(upto); !status.ok()) return status;
  }
  const auto added = std::span(samples_).subspan(done_, upto - done_);
  return on_gl_ ? on_gl_->Add(added, context_.stop)
                : moving_.Add(added, context_.arena, context_.stop);
}

absl::Status TexturePasses::ExtendBase(uint32_t upto) {
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

// What moves is taken off all samples, or off what the base leaves of them if that is known before
// the only pass.
void TexturePasses::StartCounts() {
  const size_t texels = size_t{receiver_.width} * receiver_.height;
  counts_have_base_ = IsBaseDrawn() && FirstPassSamples() >= sample_count();
  moving_.CountDown(counts_have_base_
                        ? plan_.base->counts
                        : std::vector<uint16_t>(texels, static_cast<uint16_t>(sample_count())));
}

// Of the samples done. All of them: moving_'s counts are gone then.
std::vector<uint16_t> TexturePasses::VisibleCounts() {
  const uint32_t n = sample_count();
  std::vector<uint16_t> visible = on_gl_       ? on_gl_->counts()
                                  : done_ == n ? moving_.TakeCounts()
                                               : moving_.counts();
  if (on_gl_) {
    for (uint16_t& count : visible) count = static_cast<uint16_t>(done_ - count);
  } else if (plan_.base && !counts_have_base_) {
    if (plan_.base->drawn == done_) {
      std::transform(visible.begin(), visible.end(), plan_.base->counts.begin(), visible.begin(),
                     [n](uint16_t a, uint16_t b) { return static_cast<uint16_t>(a + b - n); });
    } else {
      plan_.base->shadows.SubtractFrom(visible, done_);
    }
  }
  if (!on_gl_ && done_ < n) {
    for (uint16_t& count : visible) count = static_cast<uint16_t>(count + done_ - n);
  }
  coverage_.FillOutside(visible);
  return visible;
}

// At most the sum of what goes wrong with what moves and with what stays, which is told once.
absl::StatusOr<double> TexturePasses::ErrorOfBorrowing() {
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

absl::StatusOr<double> TexturePasses::ErrorOfBorrowing(const CasterChoice& casters) {
  OcclusionCounter exact(scene_, *light_, receiver_, surface_offset_, Rules(), casters);
  OcclusionCounter borrowing(scene_, *light_, receiver_, surface_offset_, Rules(), casters);
  return BorrowingError(exact, borrowing, samples_, lenders_, coverage_.mask().get(), receiver_,
                        context_.arena, context_.stop);
}

void TexturePasses::Shade(SoftShadowTexture& texture) {
  const Stopwatch shading(context_.now_ms);
  RunIn(context_.arena, [&] {
    texture.radiance = on_gl_ ? shading_.Finish(on_gl_->Radiance(), texture, context_.stop)
                              : shading_.Shade(texture, context_.stop);
  });
  header_.timings_ms["shading"] = shading.ElapsedMs();
  if (IsUnorm(texture.radiance->format)) {
    header_.parameters["output_scale"] = FloatText(texture.radiance->scale);
  }
}

Artifact TexturePasses::MakeArtifact() {
  SoftShadowTexture texture;
  texture.receiver = receiver_;
  texture.receiver.deviation_m = 0;
  texture.light = *light_;
  texture.coverage = coverage_.mask();
  texture.visibility = {receiver_.width, receiver_.height, done_, VisibleCounts()};
  texture.count_bits = BitsOf(params().count_bits);
  if (params().radiance) Shade(texture);
  header_.light_samples.assign(samples_.begin(), samples_.begin() + done_);
  for (LightSample& sample : header_.light_samples)
    sample.weight = 1.0f / static_cast<float>(done_);
  header_.is_final = done_ == samples_.size();
  header_.error_estimate = ErrorEstimate(done_, EffectiveSampleCount(*light_, 2) > 1);
  header_.timings_ms["compute"] = compute_ms_ + watch_.ElapsedMs();
  return {header_, std::move(texture)};
}

}  // namespace penumbra
