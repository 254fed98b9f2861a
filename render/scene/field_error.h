// Errors that a user can cause: which field, what was found, what is needed, and a stable reason.
//
//   return FieldError(absl::StatusCode::kInvalidArgument, "NON_FINITE", "lights[2].edge_v",
//                     "found NaN, need finite numbers");
//
// The message reads "lights[2].edge_v: found NaN, need finite numbers". The field path and the
// reason also travel as payloads, which the service turns into google.rpc details.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace penumbra {

absl::Status FieldError(absl::StatusCode code, std::string_view reason, std::string_view field_path,
                        std::string_view found_and_need);

// The field path and the reason that a status carries; empty when it has none.
std::string ErrorFieldPath(const absl::Status& status);
std::string ErrorReason(const absl::Status& status);

// The same error with `prefix` put before its field path and its message ("delta." for instance).
absl::Status WithFieldPrefix(const absl::Status& status, std::string_view prefix);
// The same error without `prefix` before its field path and its message, where both begin with it.
absl::Status WithoutFieldPrefix(const absl::Status& status, std::string_view prefix);

}  // namespace penumbra
