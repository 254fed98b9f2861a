// Parameters of soft_texture: what is allowed, and what was effective.
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "absl/status/status.h"
#include "render/scene/scene.h"
#include "render/technique/artifact_spec.h"
#include "render/technique/soft_texture/soft_texture_params.h"

namespace penumbra {

// Errors  kInvalidArgument RANGE, which names the field as "soft_texture.samples"
absl::Status CheckParams(const SoftTextureParams& params);

// Whether counts of `samples`, which the light has in fact, fit into the bits asked for.
//
// Errors  kInvalidArgument RANGE, soft_texture.count_bits
absl::Status CheckCountBits(const SoftTextureParams& params, size_t samples);

// All of a soft_texture's spec, as far as it can be told without computing: Technique::Check.
absl::Status CheckSpec(const Scene& scene, const ArtifactSpec& spec);

// As text, for an artifact's header, with `samples` that the light has in fact. Those that matter
// only to radiance are there where radiance is.
std::map<std::string, std::string> EffectiveParameters(const SoftTextureParams& params,
                                                       size_t samples);

}  // namespace penumbra
