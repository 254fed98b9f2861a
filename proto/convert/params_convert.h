// Parameters of techniques, both ways.
#pragma once

#include "absl/status/statusor.h"
#include "penumbra/v1/technique.pb.h"
#include "render/technique/technique_params.h"

namespace penumbra {

// One overload of Write a technique: a new one does not compile without.
void Write(const SoftTextureParams& params, v1::ArtifactSpec& proto);
void Write(const LayeredAttenuationParams& params, v1::ArtifactSpec& proto);
void Write(const CoherentRaytraceParams& params, v1::ArtifactSpec& proto);
void Write(const ShadowWidthParams& params, v1::ArtifactSpec& proto);
void Write(const ShadowVolumeParams& params, v1::ArtifactSpec& proto);

// Parameters are taken as they are: the technique checks them.
//
// Errors  kInvalidArgument UNKNOWN_TECHNIQUE: none, or one of a later protocol; RANGE: a value that
//         has no name
absl::StatusOr<TechniqueParams> ReadParams(const v1::ArtifactSpec& proto);

}  // namespace penumbra
