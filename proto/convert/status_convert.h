// absl::Status inside, google.rpc details outside: the one place that turns the one into the other.
//
//   return ToGrpcStatus(scene.status());                    // in the server
//   return FromGrpcStatus(stub->CreateScene(&context, …));  // in a client: the same error again
//
// The field path and the reason of FieldError (render/scene/field_error.h) survive the way there
// and back: the reason as ErrorInfo.reason, the path as ErrorInfo.metadata["field"] and in
// BadRequest.
#pragma once

#include "absl/status/status.h"
#include "google/rpc/status.pb.h"
#include "grpcpp/support/status.h"

namespace penumbra {

// ErrorInfo.domain of every error that this project makes.
inline constexpr char kErrorDomain[] = "penumbra";

google::rpc::Status ToProto(const absl::Status& status);
absl::Status FromProto(const google::rpc::Status& status);

grpc::Status ToGrpcStatus(const absl::Status& status);
absl::Status FromGrpcStatus(const grpc::Status& status);

}  // namespace penumbra
