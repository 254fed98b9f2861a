// Soft shadows on all surfaces of a scene at once, from layers of what a light sees.
#pragma once

#include "render/technique/technique.h"

namespace penumbra {

// For each light sample a depth map, all of them gathered into one layered depth image from the
// light's middle, with a count at each layer of the samples that see it.
//
// Shapes  a scene → an AttenuationLdi of one to ten faces
// Errors  Check: NOT_FOUND for the light, INVALID_ARGUMENT for a parameter;
//         Compute: RESOURCE_EXHAUSTED QUOTA_LDI_LAYERS, QUOTA_LDI_BYTES, VIEW_SIZE: more layers,
//         memory or pixels of a view than is allowed; FAILED_PRECONDITION NO_GL for the source gl
//         without a context
// Source  Agrawala et al. 2000, §4
class LayeredAttenuation final : public Technique {
 public:
  const TechniqueInfo& info() const override { return LayeredAttenuationParams::kInfo; }
  absl::Status Check(const Scene& scene, const ArtifactSpec& spec) const override;
  bool NeedsGl(const ArtifactSpec& spec) const override;
  absl::StatusOr<Artifact> Compute(const Scene& scene, const ArtifactSpec& spec,
                                   const ComputeContext& context) const override;
};

}  // namespace penumbra
