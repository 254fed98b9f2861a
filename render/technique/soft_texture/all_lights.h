// One texture for all lights of a scene: their radiance added up, in their colours.
//
//   ArtifactSpec spec{params, std::string(kAllLights), "floor"};
#pragma once

#include "absl/status/statusor.h"
#include "render/technique/technique.h"

namespace penumbra {

// Samples of all lights together: 20 bytes each still fit into a message of 1 MiB, and counts into
// 16 bits.
inline constexpr uint32_t kMaxSamplesOfAllLights = 52'000;

// Whether the samples of all lights are few enough to be told and counted.
//
// Errors  kNotFound: the scene has no light; kInvalidArgument RANGE: soft_texture.samples,
//         soft_texture.count_bits
absl::Status CheckAllLights(const Scene& scene, const SoftTextureParams& params);

// Computes each light's texture and adds them up: counts and radiance, which is there whether asked
// for or not. Samples come light by light, in the order of the lights' ids; the parameter `lights`
// tells which has how many. Texture.light is black, at no place, and called "*". One coarse pass
// comes first, with the first samples of every light, and each light's share of the time budget is
// the same. What `context.memory` keeps is kept for each light.
//
// The unorm scale, where none is given, is the sum of the lights' largest unoccluded radiances.
//
// `spec` must pass CheckSpec; the method gl needs `context.gl`.
//
// Errors  kCancelled: stop requested
absl::StatusOr<Artifact> ComputeAllLights(const Scene& scene, const ArtifactSpec& spec,
                                          const ComputeContext& context);

}  // namespace penumbra
