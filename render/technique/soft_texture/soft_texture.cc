#include "render/technique/soft_texture/soft_texture.h"

#include <utility>

#include "render/light_view/no_gl.h"
#include "render/technique/soft_texture/all_lights.h"
#include "render/technique/soft_texture/params_check.h"
#include "render/technique/soft_texture/texture_passes.h"

namespace penumbra {
namespace {

const SoftTextureParams& ParamsOf(const ArtifactSpec& spec) {
  return std::get<SoftTextureParams>(spec.params);
}

// As near as the CPU comes to what GL would compute: the same counts, and the same sum over samples
// in another order.
ArtifactSpec ByCpu(ArtifactSpec spec) {
  auto& params = std::get<SoftTextureParams>(spec.params);
  params.method = VisibilityMethod::kAuto;
  params.shading = Shading::kSampleSum;
  return spec;
}

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
    if (context.cpu_for_gl) return Compute(scene, ByCpu(spec), context);
    return NoGl("soft_texture.method", NameOf(VisibilityMethod::kGl), context.gl_error);
  }
  if (spec.light_id == kAllLights) return ComputeAllLights(scene, spec, context);
  TexturePasses passes(scene, spec, context);
  auto artifact = passes.Next();
  while (artifact.ok() && !artifact->header.is_final) {
    context.progress(*std::move(artifact));
    artifact = passes.Next();
  }
  return artifact;
}

}  // namespace penumbra
