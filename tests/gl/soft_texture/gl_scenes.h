// Computing soft_texture by GL and on the CPU, for comparison.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "render/gl/context.h"
#include "render/technique/technique.h"

namespace penumbra::testing {

// Of the light "light" on the receiver "receiver".
absl::StatusOr<Artifact> ComputeOnGl(gl::Context& context, const Scene& scene,
                                     SoftTextureParams params);
Artifact ComputeOnCpu(const Scene& scene, SoftTextureParams params);

const SoftShadowTexture& TextureOf(const Artifact& artifact);

// Sum over texels of |count − count|.
uint64_t DifferingSamples(const Artifact& a, const Artifact& b);

}  // namespace penumbra::testing
