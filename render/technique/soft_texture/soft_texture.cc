#include "render/technique/soft_texture/soft_texture.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "render/math/parallel_for.h"
#include "render/scene/field_error.h"
#include "render/technique/soft_texture/occlusion_counter.h"

namespace penumbra {
namespace {

// The first artifact comes after this many samples, each later one after this many times more.
constexpr uint32_t kFirstPassSamples = 8;
constexpr uint32_t kPassGrowth = 8;

// Coordinates carry 24 bits. What lies in the receiver's plane is off it by a few units in the last
// place of the largest coordinate; 32 of them are still a twentieth of a millimetre for a building
// of 30 m.
double SurfaceOffset(const Parallelogram& patch) {
  double largest = 0;
  for (const Vec2 uv : {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1), Vec2(1, 1)}) {
    const DVec3 corner = glm::abs(DVec3(patch.At(uv)));
    largest = std::max({largest, corner.x, corner.y, corner.z});
  }
  const double size = glm::length(DVec3(patch.edge_u)) + glm::length(DVec3(patch.edge_v));
  return std::ldexp(std::max(largest, size), -19);
}

// Samples that all passes up to and including `pass` count, of `n`. A last pass that would bring
// less than half as many again is merged with the one before.
uint32_t SamplesAfterPass(uint32_t pass, uint32_t n) {
  uint64_t count = kFirstPassSamples;
  for (uint32_t p = 0; p < pass && count < n; ++p) count *= kPassGrowth;
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
        receiver_(receiver),
        light_(std::move(light)),
        surface_offset_(SurfaceOffset(receiver.patch)),
        plan_(Plan(scene)),
        samples_(plan_.base_is_drawn
                     ? plan_.base->samples
                     : SampleLight(*light_, ParamsOf(spec).samples, ParamsOf(spec).seed,
                                   receiver.patch.At(Vec2(0.5f)))),
        moving_(scene, receiver_, surface_offset_, ParamsOf(spec).method, CastersOf(true)) {
    if (plan_.base) {
      moving_.CountBeyond(plan_.base->shadows);
      if (!plan_.base_is_drawn) {
        still_.emplace(scene, receiver_, surface_offset_, ParamsOf(spec).method, CastersOf(false));
        still_->StoreIn(plan_.base->shadows);
      }
    }
    header_.scene_id = scene.id();
    header_.revision = scene.revision();
    header_.scene_hash = scene.content_hash();
    header_.technique = std::string(SoftTextureParams::kInfo.name);
    header_.light_id = spec.light_id;
    header_.receiver_id = spec.receiver_id;
    header_.samples_requested = static_cast<uint32_t>(samples_.size());
    header_.parameters = {{"samples", absl::StrCat(samples_.size())},
                          {"seed", absl::StrCat(ParamsOf(spec).seed)},
                          {"radiance", ParamsOf(spec).radiance ? "true" : "false"},
                          {"surface_offset_m", absl::StrFormat("%.17g", surface_offset_)}};
  }

  absl::StatusOr<Artifact> Run() {
    const auto n = static_cast<uint32_t>(samples_.size());
    uint32_t done = 0;
    for (uint32_t pass = 0; done < n; ++pass) {
      const uint32_t upto =
          context_.progress && !plan_.base_is_drawn ? SamplesAfterPass(pass, n) : n;
      const auto added = std::span(samples_).subspan(done, upto - done);
      if (still_) {
        const auto status = still_->Add(added, context_.arena, context_.stop);
        if (!status.ok()) return status;
      }
      const auto status = moving_.Add(added, context_.arena, context_.stop);
      if (!status.ok()) return status;
      done = upto;
      header_.pass = pass;
      if (done < n) context_.progress(MakeArtifact(done));
    }
    if (still_) {
      plan_.base->counts = still_->counts();
      plan_.base->samples = samples_;
    }
    Artifact artifact = MakeArtifact(n);
    if (context_.stop.stop_requested()) return absl::CancelledError("stop requested");
    return artifact;
  }

 private:
  ShadowPlan Plan(const Scene& scene) const {
    if (!context_.memory) return {};
    return PlanShadows(*context_.memory, {receiver_, *light_, ParamsOf(spec_)}, scene);
  }
  CasterFilter CastersOf(bool moving) const {
    if (!plan_.base) return {};
    return [&ids = plan_.base->moving, moving](const std::string& id) {
      return ids.contains(id) == moving;
    };
  }

  std::vector<uint16_t> VisibleCounts(uint32_t done) const {
    const auto all = static_cast<uint16_t>(done);
    const std::vector<uint16_t>& hidden = moving_.counts();
    std::vector<uint16_t> visible(hidden.size());
    const auto beyond = [all](uint16_t a, uint16_t b) {
      return static_cast<uint16_t>(all - a - b);
    };
    if (plan_.base) {
      const std::vector<uint16_t>& base = still_ ? still_->counts() : plan_.base->counts;
      std::transform(hidden.begin(), hidden.end(), base.begin(), visible.begin(), beyond);
    } else {
      std::transform(hidden.begin(), hidden.end(), visible.begin(),
                     [&](uint16_t a) { return beyond(a, 0); });
    }
    return visible;
  }

  Artifact MakeArtifact(uint32_t done) {
    SoftShadowTexture texture{
        .receiver = receiver_, .light = *light_, .visibility = {}, .radiance = {}};
    texture.visibility = {receiver_.width, receiver_.height, done, VisibleCounts(done)};
    if (ParamsOf(spec_).radiance) {
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
  ReceiverPatch receiver_;
  std::shared_ptr<const AreaLight> light_;
  double surface_offset_;
  ShadowPlan plan_;
  std::vector<LightSample> samples_;
  // What is drawn over the base, or everything where there is none; and the base, where it is to be
  // drawn.
  OcclusionCounter moving_;
  std::optional<OcclusionCounter> still_;
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
  if (!scene.FindLight(spec.light_id)) {
    return FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "light_id",
                      absl::StrCat("found ", spec.light_id, ", need a light of the scene"));
  }
  return scene.ResolveReceiver(spec.receiver_id).status();
}

absl::StatusOr<Artifact> SoftTexture::Compute(const Scene& scene, const ArtifactSpec& spec,
                                              const ComputeContext& context) const {
  if (const auto status = Check(scene, spec); !status.ok()) return status;
  return Computation(scene, spec, context, *scene.ResolveReceiver(spec.receiver_id),
                     scene.FindLight(spec.light_id))
      .Run();
}

}  // namespace penumbra
