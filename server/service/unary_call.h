// A unary call from bytes to bytes, past the guard.
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/byte_buffer.h"
#include "proto/convert/status_convert.h"
#include "server/service/penumbra_service.h"
#include "server/session/bounded_parse.h"
#include "server/session/wire_message.h"

namespace penumbra {

// The answer of `answer(message, caller)`, an absl::StatusOr of the response, to those who may call
// `name` and, where the request names one, on its scene. `answer` must not take long.
template <typename Request, typename Answer>
auto AnswerIfAllowed(grpc::CallbackServerContext& context, const ServiceParts& parts,
                     std::string_view name, const grpc::ByteBuffer& request, const Answer& answer)
    -> decltype(answer(std::declval<const Request&>(), std::declval<const Caller&>())) {
  const auto caller = parts.guard.Admit(context, name);
  if (!caller.ok()) return caller.status();
  Request message;
  if (auto status = ParseBounded(request, parts.sessions.limits, message); !status.ok()) {
    return status;
  }
  if constexpr (requires { message.scene_id(); }) {
    if (auto status = caller->Authorize(name, message.scene_id()); !status.ok()) return status;
  }
  return answer(message, *caller);
}

template <typename Request, typename Answer>
grpc::ServerUnaryReactor* AnswerUnary(grpc::CallbackServerContext* context,
                                      const ServiceParts& parts, std::string_view name,
                                      const grpc::ByteBuffer* request, grpc::ByteBuffer* response,
                                      const Answer& answer) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  const auto result = AnswerIfAllowed<Request>(*context, parts, name, *request, answer);
  if (result.ok()) *response = ToBytes(*result);
  reactor->Finish(ToGrpcStatus(result.status()));
  return reactor;
}

}  // namespace penumbra
