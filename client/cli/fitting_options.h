// Whether what was asked for is of the technique that was chosen.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "client/cli/commands.h"

namespace penumbra {

// Errors  kInvalidArgument CONFLICT, with an option as the field path that the request's technique
//         does nothing with: receivers and their texels for one that takes none, pictures,
//         lightmaps and points for one that is not computed at points
absl::Status CheckOptionsFit(const ShadowRequest& request);

// Of a view, its own options too.
//
// Errors  kInvalidArgument CONFLICT: as above; back faces left out of a picture that is traced;
//         how dark shadows are, of a shading that does not darken by it
absl::Status CheckOptionsFit(const ViewCommand& command);

// Errors  kInvalidArgument CONFLICT, "--light": all lights in one, of a technique that takes one
absl::Status CheckLightsFit(const std::vector<std::string>& light_ids,
                            const TechniqueParams& params);

// kInvalidArgument CONFLICT: `option` says nothing to the technique of `params`. `need` is another
// technique, or what to give in its place.
absl::Status TechniqueConflict(std::string_view option, const TechniqueParams& params,
                               std::string_view need);

}  // namespace penumbra
