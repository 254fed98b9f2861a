// Whether what was asked for is of the technique that was chosen.
#pragma once

#include <string_view>

#include "absl/status/status.h"
#include "client/cli/commands.h"

namespace penumbra {

// Errors  kInvalidArgument CONFLICT, with an option as the field path that the request's technique
//         does nothing with: receivers and their texels for one that takes none, pictures,
//         lightmaps and points for one that is not computed at points
absl::Status CheckOptionsFit(const ShadowRequest& request);

// kInvalidArgument CONFLICT: `option` says nothing to the technique of `params`. `need` is another
// technique, or what to give in its place.
absl::Status TechniqueConflict(std::string_view option, const TechniqueParams& params,
                               std::string_view need);

}  // namespace penumbra
