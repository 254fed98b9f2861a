// Files that configure the server: keys, certificates, identities.
#pragma once

#include <string>

#include "absl/status/statusor.h"

namespace penumbra {

// All of a file of at most 1 MiB. `option` is the one that named it, for the error's text.
//
// Errors  kInvalidArgument CANNOT_READ, field `option`
absl::StatusOr<std::string> ReadSmallFile(const std::string& path, const std::string& option);

}  // namespace penumbra
