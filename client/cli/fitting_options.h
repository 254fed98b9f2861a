// Whether what was asked for is of the technique that was chosen.
#pragma once

#include "absl/status/status.h"
#include "client/cli/commands.h"

namespace penumbra {

// Errors  kInvalidArgument CONFLICT, with an option as the field path that the request's technique
//         does nothing with: receivers and their texels for one that takes none, pictures,
//         lightmaps and points for one that is not computed at points
absl::Status CheckOptionsFit(const ShadowRequest& request);

}  // namespace penumbra
