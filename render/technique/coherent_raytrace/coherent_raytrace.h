// The final picture: soft shadows at points, sampled anew at each.
#pragma once

#include "render/technique/technique.h"

namespace penumbra {

// Shadow rays to a jittered sample in each cell of the light, traced only where a point's
// visibility is likely to differ from that of the point before it.
//
// Shapes  H×W points → a ViewShadow of H×W counts in [0, n] and radiance
// Errors  Check: NOT_FOUND for the light or the lightmap's instance, INVALID_ARGUMENT for a
//         parameter or the points, FAILED_PRECONDITION MISSING_UV: the instance's mesh has no uvs
// Source  Agrawala et al. 2000, §5
class CoherentRaytrace final : public Technique {
 public:
  const TechniqueInfo& info() const override { return CoherentRaytraceParams::kInfo; }
  absl::Status Check(const Scene& scene, const ArtifactSpec& spec) const override;
  absl::StatusOr<Artifact> Compute(const Scene& scene, const ArtifactSpec& spec,
                                   const ComputeContext& context) const override;
};

}  // namespace penumbra
