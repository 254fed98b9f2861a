// What an artifact is, apart from its texels (tile_codec.h), both ways.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "penumbra/v1/artifact.pb.h"
#include "render/artifact/artifact.h"
#include "render/scene/scene_limits.h"

namespace penumbra {

// Without light samples, which travel apart from the header since they seldom change.
v1::ArtifactHeader ToProto(const Artifact& artifact);

// The artifact with all counts 0, radiance black, no texel inside where there is a mask, and no
// light samples.
//
// Errors  kInvalidArgument MISSING_FIELD: no kind that this program knows; LENGTH; RANGE: the grid
//         is empty or larger than `limits` allow, found before anything is allocated
absl::StatusOr<Artifact> FromProto(const v1::ArtifactHeader& header,
                                   const SceneLimits& limits = {});

v1::RadianceFormat ToProto(RadianceFormat format);

std::string EncodeLightSamples(std::span<const LightSample> samples);
// Errors  kInvalidArgument LENGTH
absl::StatusOr<std::vector<LightSample>> DecodeLightSamples(const std::string& bytes);

}  // namespace penumbra
