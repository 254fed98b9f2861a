// What a fuzz target holds to be true. Where it is not, the process ends, which a fuzzer takes for
// a finding and a test run for a failure.
//
//   Require(after->content_hash() == hash, "a refused delta has changed the scene");
//   RequireRefusal(delta.status());
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "render/scene/field_error.h"

namespace penumbra::fuzzing {

inline void Require(bool holds, std::string_view what) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %.*s\n", static_cast<int>(what.size()), what.data());
  std::abort();
}

// Whether an error is one that a user can cause, says why and where, and is of a size to be read.
inline void RequireRefusal(const absl::Status& status) {
  const absl::StatusCode code = status.code();
  Require(code != absl::StatusCode::kInternal && code != absl::StatusCode::kUnknown &&
              code != absl::StatusCode::kOk,
          "a refusal of a user's mistake: " + status.ToString());
  Require(!ErrorReason(status).empty(), "a refusal without a reason: " + status.ToString());
  Require(status.message().size() < 4'096, "a refusal in fewer words");
}

// Likewise, and whether it names the field.
inline void RequireNamedRefusal(const absl::Status& status) {
  RequireRefusal(status);
  Require(!ErrorFieldPath(status).empty(), "a refusal names the field: " + status.ToString());
}

}  // namespace penumbra::fuzzing
