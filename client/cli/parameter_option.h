// NAME=VALUE: any parameter of the technique that was chosen.
#pragma once

#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "render/technique/technique_params.h"

namespace penumbra {

// `text` is what was given with `option`.
//
// Errors  kInvalidArgument, with the option as the field path: not NAME=VALUE, or no such parameter
//         of the technique; with "OPTION NAME" as the field path: not a value of its type
absl::Status SetParameter(std::string_view option, TechniqueParams& params, std::string_view text);

// The soft_texture's parameters, for an option that only it has.
//
// Errors  kInvalidArgument CONFLICT, with the option as the field path
absl::StatusOr<SoftTextureParams*> OfSoftTexture(std::string_view option, TechniqueParams& params);

}  // namespace penumbra
