// A unary call from bytes to bytes, past the guard.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/byte_buffer.h"
#include "proto/convert/status_convert.h"
#include "render/engine/worker_pool.h"
#include "server/service/call_record.h"
#include "server/service/penumbra_service.h"
#include "server/session/bounded_parse.h"
#include "server/session/wire_message.h"

namespace penumbra {

// "CreateScene" for a CreateSceneRequest, as the protocol names all its messages.
template <typename Request>
std::string MethodOf() {
  std::string name = Request::descriptor()->name();
  constexpr std::string_view kSuffix = "Request";
  return name.erase(name.size() - kSuffix.size());
}

// The answer of `answer(message, caller)`, an absl::StatusOr of the response, to those who may make
// the call and, where the request names a scene, on that.
template <typename Request, typename Answer>
auto AnswerIfAllowed(grpc::CallbackServerContext& context, const ServiceParts& parts,
                     const grpc::ByteBuffer& request, const Answer& answer)
    -> decltype(answer(std::declval<const Request&>(), std::declval<const Caller&>())) {
  const std::string name = MethodOf<Request>();
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

// Finishes the call with that. `answer` may wait for the disk where `lane` is one, on whose thread
// it then runs; where there is none it must not take long.
template <typename Request, typename Answer>
grpc::ServerUnaryReactor* AnswerUnaryOn(WorkerPool::Lane* lane, const ServiceParts& parts,
                                        grpc::CallbackServerContext* context,
                                        const grpc::ByteBuffer* request, grpc::ByteBuffer* response,
                                        Answer answer) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  const auto record =
      std::make_shared<CallRecord>(parts.sessions.counters, parts.logger, MethodOf<Request>());
  auto finish = [&parts, context, request, response, reactor, record, answer = std::move(answer)] {
    const auto result = AnswerIfAllowed<Request>(*context, parts, *request, answer);
    if (result.ok()) *response = ToBytes(*result);
    record->End(result.status());
    reactor->Finish(ToGrpcStatus(result.status()));
  };
  if (lane) {
    lane->Post(std::move(finish));
  } else {
    finish();
  }
  return reactor;
}

template <typename Request, typename Answer>
grpc::ServerUnaryReactor* AnswerUnary(const ServiceParts& parts,
                                      grpc::CallbackServerContext* context,
                                      const grpc::ByteBuffer* request, grpc::ByteBuffer* response,
                                      Answer answer) {
  return AnswerUnaryOn<Request>(nullptr, parts, context, request, response, std::move(answer));
}

}  // namespace penumbra
