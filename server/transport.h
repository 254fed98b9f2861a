// How the server's gRPC is set up: sizes, timeouts and what is switched off.
#pragma once

#include "grpcpp/server_builder.h"
#include "server/limits.h"

namespace penumbra {

// Call before any ServerBuilder is made: switches the health service on.
void PrepareTransport();

// Applies `limits`; `with_reflection` lets clients ask for the service's description.
void ConfigureTransport(const ServerLimits& limits, bool with_reflection,
                        grpc::ServerBuilder& builder);

// The reflection library adds itself to every server of the process as soon as it is loaded; this
// takes it out again.
void LeaveOutReflection(grpc::ServerBuilder& builder);

}  // namespace penumbra
