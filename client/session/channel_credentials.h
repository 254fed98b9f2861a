// From what a client shows to what gRPC takes.
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "client/session/client_credentials.h"
#include "grpcpp/client_context.h"
#include "grpcpp/security/credentials.h"

namespace penumbra {

// Errors  kInvalidArgument: NEEDS_TLS, a token for another machine without TLS; CANNOT_READ, field
//         "tls-ca", "tls-certificate" or "tls-key"; MISSING_FIELD, a certificate or a key alone;
//         BAD_TOKEN, one that cannot be in a header. No text has the token.
absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> MakeChannelCredentials(
    const std::string& address, const ClientCredentials& credentials);

// Puts the token, if there is one, into a call.
void ShowToken(const ClientCredentials& credentials, grpc::ClientContext& context);

}  // namespace penumbra
