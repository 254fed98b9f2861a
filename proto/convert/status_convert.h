// absl::Status inside, google.rpc details outside: the one place that turns the one into the other.
//
//   return ToGrpcStatus(scene.status());                    // in the server
//   return FromGrpcStatus(stub->CreateScene(&context, …));  // in a client: the same error again
//
// The field path and the reason of FieldError (render/scene/field_error.h) survive the way there
// and back: the reason as ErrorInfo.reason, the path as ErrorInfo.metadata["field"] and in
// BadRequest. So does the delay of WithRetryDelay (render/scene/retry_delay.h), as RetryInfo, in
// whole milliseconds.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "google/rpc/status.pb.h"
#include "grpcpp/support/status.h"

namespace penumbra {

// ErrorInfo.domain of every error that this project makes.
inline constexpr char kErrorDomain[] = "penumbra";

google::rpc::Status ToProto(const absl::Status& status);
absl::Status FromProto(const google::rpc::Status& status);

grpc::Status ToGrpcStatus(const absl::Status& status);
// Also of a status without details, for a message of MessageWithReason.
absl::Status FromGrpcStatus(const grpc::Status& status);

// For an end of a call that takes a code and a message and no details: "[REASON] " before the
// message. The field path is not in it.
std::string MessageWithReason(const absl::Status& status);

}  // namespace penumbra
