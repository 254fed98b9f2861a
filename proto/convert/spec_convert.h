// Specs and what techniques say of themselves, both ways.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "penumbra/v1/technique.pb.h"
#include "render/technique/artifact_spec.h"
#include "render/technique/technique_info.h"

namespace penumbra {

v1::ArtifactSpec ToProto(const ArtifactSpec& spec);

// Parameters are taken as they are: the technique checks them.
//
// Errors  kInvalidArgument UNKNOWN_TECHNIQUE: none, or one of a later protocol; BAD_ID; those of
//         CheckTarget and CheckTimeBudget
absl::StatusOr<ArtifactSpec> FromProto(const v1::ArtifactSpec& spec);
// What the spec's technique computes for. Errors  kInvalidArgument UNKNOWN_TECHNIQUE, RANGE
absl::StatusOr<SpecTarget> TargetOf(const v1::ArtifactSpec& spec);

v1::TechniqueInfo ToProto(const TechniqueInfo& info);

// All techniques of the one list, technique_params.h.
std::vector<v1::TechniqueInfo> AllTechniqueInfos();

}  // namespace penumbra
