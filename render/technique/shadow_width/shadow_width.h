// Soft shadows on all surfaces of a scene from a single light sample.
#pragma once

#include "render/technique/technique.h"

namespace penumbra {

// What the light's middle sees of the scene, which of it is a blocker, and how far each blocked
// texel is from a lit one.
//
// Shapes  a scene → a ShadowWidthMap of one to ten faces
// Errors  Check: NOT_FOUND for the light, INVALID_ARGUMENT for a parameter;
//         Compute: FAILED_PRECONDITION NO_GL for what GL is asked to do without a context;
//         RESOURCE_EXHAUSTED QUOTA_WIDTH_TEXELS: all faces together have too many
// Source  Kirsch and Döllner 2003
class ShadowWidth final : public Technique {
 public:
  const TechniqueInfo& info() const override { return ShadowWidthParams::kInfo; }
  absl::Status Check(const Scene& scene, const ArtifactSpec& spec) const override;
  bool NeedsGl(const ArtifactSpec& spec) const override;
  absl::StatusOr<Artifact> Compute(const Scene& scene, const ArtifactSpec& spec,
                                   const ComputeContext& context) const override;
};

}  // namespace penumbra
