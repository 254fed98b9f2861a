// Soft shadows on a planar patch, by counting hard shadows.
#pragma once

#include "render/technique/technique.h"

namespace penumbra {

// For each light sample, the projective map that takes the pyramid over the receiver to the unit
// box draws every occluder's shadow as plain polygons in texel space; a texel's count is the number
// of samples whose shadow misses it.
//
// Shapes  a receiver of H×W texels → a SoftShadowTexture of H×W counts in [0, n]
// Errors  Check: NOT_FOUND for the light or the receiver, INVALID_ARGUMENT for `samples`;
//         Compute: FAILED_PRECONDITION NO_GL for the method gl without a context
// Source  Herf 1997, §3.2 and §4.2; departs: one bit a texel and sample instead of a byte image,
// and
//         faces of closed meshes that look away from the light are left out
class SoftTexture final : public Technique {
 public:
  const TechniqueInfo& info() const override { return SoftTextureParams::kInfo; }
  absl::Status Check(const Scene& scene, const ArtifactSpec& spec) const override;
  bool NeedsGl(const ArtifactSpec& spec) const override;
  absl::StatusOr<Artifact> Compute(const Scene& scene, const ArtifactSpec& spec,
                                   const ComputeContext& context) const override;
};

}  // namespace penumbra
