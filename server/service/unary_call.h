// A unary call from bytes to bytes.
#pragma once

#include "absl/status/statusor.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/byte_buffer.h"
#include "proto/convert/status_convert.h"
#include "server/limits.h"
#include "server/session/bounded_parse.h"
#include "server/session/wire_message.h"

namespace penumbra {

// `answer` takes a Request and gives an absl::StatusOr of the response. It must not take long.
template <typename Request, typename Answer>
grpc::ServerUnaryReactor* AnswerUnary(grpc::CallbackServerContext* context,
                                      const ServerLimits& limits, const grpc::ByteBuffer* request,
                                      grpc::ByteBuffer* response, Answer answer) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  Request message;
  absl::Status status = ParseBounded(*request, limits, message);
  if (status.ok()) {
    const auto result = answer(message);
    status = result.status();
    if (result.ok()) *response = ToBytes(*result);
  }
  reactor->Finish(ToGrpcStatus(status));
  return reactor;
}

}  // namespace penumbra
