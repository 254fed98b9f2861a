#include "tests/gl/soft_texture/gl_scenes.h"

#include <cstdlib>

namespace penumbra::testing {

absl::StatusOr<Artifact> ComputeOnGl(gl::Context& context, const Scene& scene,
                                     SoftTextureParams params) {
  params.method = VisibilityMethod::kGl;
  const ArtifactSpec spec{.params = params, .light_id = "light", .receiver_id = "receiver"};
  tbb::task_arena arena(2);
  return TechniqueFor(spec.params).Compute(scene, spec, {.arena = arena, .gl = &context});
}

Artifact ComputeOnCpu(const Scene& scene, SoftTextureParams params) {
  const ArtifactSpec spec{.params = params, .light_id = "light", .receiver_id = "receiver"};
  tbb::task_arena arena(2);
  return TechniqueFor(spec.params).Compute(scene, spec, {.arena = arena}).value();
}

const SoftShadowTexture& TextureOf(const Artifact& artifact) {
  return std::get<SoftShadowTexture>(artifact.payload);
}

uint64_t DifferingSamples(const Artifact& a, const Artifact& b) {
  const auto& counts = TextureOf(a).visibility.counts;
  const auto& others = TextureOf(b).visibility.counts;
  uint64_t differing = 0;
  for (size_t t = 0; t < counts.size(); ++t) differing += std::abs(counts[t] - others[t]);
  return differing;
}

}  // namespace penumbra::testing
