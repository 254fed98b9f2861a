// The boundary of a light's hard shadows, from what its middle sees.
#pragma once

#include "render/technique/technique.h"

namespace penumbra {

// One volume of all casters, or one of each, of which those of casters that did not change are kept
// from revision to revision.
//
// Shapes  a scene → a ShadowVolumeMesh
// Errors  Check: NOT_FOUND for the light, INVALID_ARGUMENT for a parameter;
//         Compute: FAILED_PRECONDITION NO_GL where GL is to draw and there is none;
//         RESOURCE_EXHAUSTED QUOTA_VOLUME_TEXELS, QUOTA_VOLUME_TRIANGLES: all maps, or all
//         volumes, together have too many
// Source  McCool 2000
class ShadowVolumes final : public Technique {
 public:
  const TechniqueInfo& info() const override { return ShadowVolumeParams::kInfo; }
  absl::Status Check(const Scene& scene, const ArtifactSpec& spec) const override;
  bool NeedsGl(const ArtifactSpec& spec) const override;
  absl::StatusOr<Artifact> Compute(const Scene& scene, const ArtifactSpec& spec,
                                   const ComputeContext& context) const override;
};

}  // namespace penumbra
