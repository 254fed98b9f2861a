// How long to wait before asking again, on errors that may pass by themselves.
//
//   return WithRetryDelay(FieldError(absl::StatusCode::kResourceExhausted, …), 250);
//
// It travels as a payload, which the service turns into google.rpc.RetryInfo.
#pragma once

#include <optional>

#include "absl/status/status.h"

namespace penumbra {

// `delay_ms` ≥ 0.
absl::Status WithRetryDelay(absl::Status status, double delay_ms);

// In milliseconds; none: asking again is no use, or nobody knows when.
std::optional<double> RetryDelayMs(const absl::Status& status);

}  // namespace penumbra
