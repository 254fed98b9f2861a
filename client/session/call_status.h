// What became of a call, in the project's own terms: the errors that the server made come out as it
// made them, those of the transport as kUnavailable with the address in front.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "grpcpp/support/status.h"

namespace penumbra {

// Of a unary call, or of one that uploads or downloads.
absl::Status StatusOfCall(const std::string& address, const grpc::Status& status);

// Of a session that has ended without being asked to: never OK.
absl::Status StatusOfEndedSession(const std::string& address, const grpc::Status& status);

}  // namespace penumbra
