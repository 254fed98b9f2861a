#include "render/technique/soft_texture/all_lights.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "render/math/float_text.h"
#include "render/scene/field_error.h"
#include "render/technique/soft_texture/params_check.h"
#include "render/technique/soft_texture/texture_passes.h"
#include "render/technique/soft_texture/texture_shading.h"

namespace penumbra {
namespace {

// What is kept of each light, by its id.
using KeptOfLights = std::map<std::string, TechniqueMemory>;

// Lights whose counting stands still between the coarse pass and the final one, and goes on from
// there; the first samples of others are counted twice. What one holds may be megabytes.
constexpr size_t kMostStanding = 8;

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

  void Add(const std::string& light_id, const Artifact& artifact) {
    const auto& share = std::get<SoftShadowTexture>(artifact.payload);
    requested_ += artifact.header.samples_requested;
    is_final_ = is_final_ && artifact.header.is_final;
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
      total_ = artifact;
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

  Artifact Finish(uint32_t pass) {
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
    header.samples_requested = requested_;
    header.is_final = is_final_;
    header.pass = pass;
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
    if (is_final_ && BorrowsOutlines(params())) {
      header.parameters["silhouette_reuse_error"] = absl::StrFormat("%.3g", borrowing_error_);
    }
    if (IsUnorm(texture.radiance->format)) {
      header.parameters["output_scale"] = FloatText(texture.radiance->scale);
    }
    return std::move(total_);
  }

 private:
  const SoftTextureParams& params() const { return std::get<SoftTextureParams>(spec_.params); }

  const ArtifactSpec& spec_;
  Artifact total_;
  std::string lights_;
  uint32_t requested_ = 0;
  bool is_final_ = true;
  double variance_ = 0;
  double borrowing_error_ = 0;  // of the light where it is largest
  float scale_ = 0;
};

using SharedArtifact = std::shared_ptr<const Artifact>;

absl::StatusOr<SharedArtifact> Shared(absl::StatusOr<Artifact> artifact) {
  if (!artifact.ok()) return artifact.status();
  return std::make_shared<const Artifact>(*std::move(artifact));
}

// One light's texture, at first with few samples and then with all.
class Share {
 public:
  Share(const Scene& scene, const ArtifactSpec& spec, const std::string& light_id,
        const ComputeContext& context, TechniqueMemory* memory)
      : scene_(scene),
        spec_{ShareOf(std::get<SoftTextureParams>(spec.params)), light_id, spec.receiver_id,
              spec.time_budget_ms / static_cast<float>(scene.lights().size())},
        context_(context) {
    context_.memory = memory;
  }

  const std::string& light_id() const { return spec_.light_id; }

  // `may_stand`: what is counted may be kept for Final.
  absl::StatusOr<SharedArtifact> Coarse(bool may_stand) {
    auto passes = std::make_unique<TexturePasses>(scene_, spec_, context_);
    const auto artifact = Shared(passes->Next());
    if (!may_stand || !artifact.ok()) return artifact;
    if ((*artifact)->header.is_final) {
      final_ = *artifact;
    } else {
      passes_ = std::move(passes);
    }
    return artifact;
  }

  absl::StatusOr<SharedArtifact> Final() {
    if (final_) return std::exchange(final_, nullptr);
    if (!passes_) {
      context_.progress = nullptr;
      passes_ = std::make_unique<TexturePasses>(scene_, spec_, context_);
    }
    const auto artifact = Shared(passes_->Last());
    passes_.reset();
    return artifact;
  }

 private:
  const Scene& scene_;
  ArtifactSpec spec_;
  ComputeContext context_;
  std::unique_ptr<TexturePasses> passes_;  // begun and not ended
  SharedArtifact final_;                   // if it came with the coarse ones
};

using Shares = std::vector<std::unique_ptr<Share>>;

absl::StatusOr<Artifact> AddUp(
    const ArtifactSpec& spec, const Shares& shares, uint32_t pass,
    absl::FunctionRef<absl::StatusOr<SharedArtifact>(size_t share)> get) {
  Sum sum(spec);
  for (size_t i = 0; i < shares.size(); ++i) {
    const auto artifact = get(i);
    if (!artifact.ok()) return artifact.status();
    sum.Add(shares[i]->light_id(), **artifact);
  }
  return sum.Finish(pass);
}

// What `memory` keeps of the scene's lights; null: nothing may be kept.
std::shared_ptr<KeptOfLights> KeptIn(TechniqueMemory* memory, const Scene& scene) {
  if (!memory) return nullptr;
  auto kept = std::static_pointer_cast<KeptOfLights>(memory->kept);
  if (!kept) kept = std::make_shared<KeptOfLights>();
  memory->kept = kept;
  std::erase_if(*kept, [&](const auto& entry) { return !scene.FindLight(entry.first); });
  return kept;
}

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

absl::StatusOr<Artifact> ComputeAllLights(const Scene& scene, const ArtifactSpec& spec,
                                          const ComputeContext& context) {
  const auto kept = KeptIn(context.memory, scene);
  Shares shares;
  for (const auto& [id, light] : scene.lights()) {
    TechniqueMemory* memory = nullptr;
    if (kept)
      memory = &kept->try_emplace(id, TechniqueMemory{context.memory->budget}).first->second;
    shares.push_back(std::make_unique<Share>(scene, spec, id, context, memory));
  }
  uint32_t pass = 0;
  if (context.progress) {
    const auto coarse_of = [&](size_t i) { return shares[i]->Coarse(i < kMostStanding); };
    auto coarse = AddUp(spec, shares, pass++, coarse_of);
    if (!coarse.ok() || coarse->header.is_final) return coarse;
    context.progress(*std::move(coarse));
  }
  return AddUp(spec, shares, pass, [&](size_t i) { return shares[i]->Final(); });
}

}  // namespace penumbra
