#include "render/technique/soft_texture/all_lights.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "render/scene/field_error.h"
#include "render/technique/soft_texture/params_check.h"
#include "render/technique/soft_texture/texture_shading.h"

namespace penumbra {
namespace {

// What is kept of each light, by its id.
using KeptOfLights = std::map<std::string, std::shared_ptr<void>>;

// One light's share: exact, and without what is added once for all.
SoftTextureParams ShareOf(SoftTextureParams params) {
  params.radiance = true;
  params.ambient = Vec3(0.0f);
  params.output = RadianceFormat::kFloat32;
  params.count_bits = CountBits::kAuto;
  return params;
}

class Sum {
 public:
  explicit Sum(const ArtifactSpec& spec) : spec_(spec) {}

  void Add(const std::string& light_id, Artifact artifact) {
    auto& share = std::get<SoftShadowTexture>(artifact.payload);
    const uint32_t samples = share.visibility.sample_count;
    absl::StrAppend(&lights_, lights_.empty() ? "" : " ", light_id, ":", samples);
    const double uncertain = double{artifact.header.error_estimate} * samples;
    variance_ += uncertain * uncertain;
    const auto error = artifact.header.parameters.find("silhouette_reuse_error");
    if (error != artifact.header.parameters.end()) {
      borrowing_error_ = std::max(borrowing_error_, std::stod(error->second));
    }
    scale_ += LargestUnoccluded(share, params().form_factor_error);
    if (total_.header.technique.empty()) {
      total_ = std::move(artifact);
      return;
    }
    auto& texture = std::get<SoftShadowTexture>(total_.payload);
    for (size_t t = 0; t < texture.visibility.counts.size(); ++t) {
      texture.visibility.counts[t] += share.visibility.counts[t];
      texture.radiance->texels[t] += share.radiance->texels[t];
    }
    texture.visibility.sample_count += samples;
    ArtifactHeader& header = total_.header;
    const auto& more = artifact.header.light_samples;
    header.light_samples.insert(header.light_samples.end(), more.begin(), more.end());
    for (const auto& [stage, ms] : artifact.header.timings_ms) header.timings_ms[stage] += ms;
  }

  Artifact Finish() {
    auto& texture = std::get<SoftShadowTexture>(total_.payload);
    const uint32_t samples = texture.visibility.sample_count;
    texture.light = {.id = std::string(kAllLights), .shape = PointLight{.intensity = Vec3(0.0f)}};
    texture.count_bits = BitsOf(params().count_bits);
    const Vec3 ambient = texture.receiver.reflectance * params().ambient;
    for (Vec3& texel : texture.radiance->texels) texel += ambient;
    const float largest = scale_ + std::max({ambient.x, ambient.y, ambient.z});
    const float found = largest > 0 && std::isfinite(largest) ? largest : 1;
    RoundTo(params().output, params().output_scale > 0 ? params().output_scale : found,
            *texture.radiance);
    ArtifactHeader& header = total_.header;
    header.light_id = std::string(kAllLights);
    header.samples_requested = samples;
    header.pass = 0;
    header.error_estimate = static_cast<float>(std::sqrt(variance_) / samples);
    for (LightSample& sample : header.light_samples) {
      sample.weight = 1.0f / static_cast<float>(samples);
    }
    SoftTextureParams effective = params();
    effective.radiance = true;
    const std::string offset = header.parameters["surface_offset_m"];
    header.parameters = EffectiveParameters(effective, params().samples);
    header.parameters["surface_offset_m"] = offset;
    header.parameters["lights"] = lights_;
    if (BorrowsOutlines(params())) {
      header.parameters["silhouette_reuse_error"] = absl::StrFormat("%.3g", borrowing_error_);
    }
    if (IsUnorm(texture.radiance->format)) {
      header.parameters["output_scale"] = absl::StrFormat("%.9g", texture.radiance->scale);
    }
    return std::move(total_);
  }

 private:
  const SoftTextureParams& params() const { return std::get<SoftTextureParams>(spec_.params); }

  const ArtifactSpec& spec_;
  Artifact total_;
  std::string lights_;
  double variance_ = 0;
  double borrowing_error_ = 0;  // of the light where it is largest
  float scale_ = 0;
};

}  // namespace

absl::Status CheckAllLights(const Scene& scene, const SoftTextureParams& params) {
  if (scene.lights().empty()) {
    return FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "light_id",
                      "found * in a scene without lights, need a light");
  }
  uint64_t samples = 0;
  for (const auto& [id, light] : scene.lights()) {
    samples += EffectiveSampleCount(*light, params.samples);
  }
  if (samples > kMaxSamplesOfAllLights) {
    return FieldError(
        absl::StatusCode::kInvalidArgument, "RANGE", "soft_texture.samples",
        absl::StrCat("found ", samples, " of all lights, need at most ", kMaxSamplesOfAllLights));
  }
  return CheckCountBits(params, samples);
}

absl::StatusOr<Artifact> ComputeAllLights(const Technique& technique, const Scene& scene,
                                          const ArtifactSpec& spec, const ComputeContext& context) {
  std::shared_ptr<KeptOfLights> kept;
  if (context.memory) {
    kept = std::static_pointer_cast<KeptOfLights>(context.memory->kept);
    if (!kept) kept = std::make_shared<KeptOfLights>();
    context.memory->kept = kept;
    std::erase_if(*kept, [&](const auto& entry) { return !scene.FindLight(entry.first); });
  }
  Sum sum(spec);
  for (const auto& [id, light] : scene.lights()) {
    const ArtifactSpec share{ShareOf(std::get<SoftTextureParams>(spec.params)), id,
                             spec.receiver_id};
    std::optional<TechniqueMemory> memory;
    if (kept) memory.emplace(TechniqueMemory{context.memory->budget, (*kept)[id]});
    const ComputeContext one{.arena = context.arena,
                             .gl = context.gl,
                             .stop = context.stop,
                             .progress = nullptr,
                             .now_ms = context.now_ms,
                             .memory = memory ? &*memory : nullptr};
    auto artifact = technique.Compute(scene, share, one);
    if (kept) (*kept)[id] = memory->kept;
    if (!artifact.ok()) return artifact.status();
    sum.Add(id, *std::move(artifact));
  }
  return sum.Finish();
}

}  // namespace penumbra
