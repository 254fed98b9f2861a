// A unary call from bytes to bytes.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/byte_buffer.h"
#include "proto/convert/status_convert.h"
#include "server/service/call_record.h"
#include "server/service/penumbra_service.h"
#include "server/session/bounded_parse.h"
#include "server/session/wire_message.h"

namespace penumbra {

// "CreateScene" for CreateSceneRequest.
template <typename Request>
std::string MethodOf() {
  const std::string& name = Request::descriptor()->name();
  return name.substr(0, name.rfind("Request"));
}

// `answer` takes a Request and gives an absl::StatusOr of the response. It must not take long.
template <typename Request, typename Answer>
grpc::ServerUnaryReactor* AnswerUnary(const ServiceParts& parts,
                                      grpc::CallbackServerContext* context,
                                      const grpc::ByteBuffer* request, grpc::ByteBuffer* response,
                                      Answer answer) {
  CallRecord record(parts.sessions.counters, parts.logger, MethodOf<Request>());
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  Request message;
  absl::Status status = ParseBounded(*request, parts.sessions.limits, message);
  if (status.ok()) {
    const auto result = answer(message);
    status = result.status();
    if (result.ok()) *response = ToBytes(*result);
  }
  record.End(status);
  reactor->Finish(ToGrpcStatus(status));
  return reactor;
}

}  // namespace penumbra
