// A unary call from bytes to bytes, past the guard.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/byte_buffer.h"
#include "proto/convert/status_convert.h"
#include "server/fair_lane.h"
#include "server/service/call_record.h"
#include "server/service/idle_timer.h"
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

// Who makes the call, if they may, and on the scene that the request names where it names one.
template <typename Request>
absl::StatusOr<Caller> AdmitRequest(grpc::CallbackServerContext& context, const ServiceParts& parts,
                                    const grpc::ByteBuffer& bytes, Request& message) {
  const std::string name = MethodOf<Request>();
  auto caller = parts.guard.Admit(context, name);
  if (!caller.ok()) return caller.status();
  if (auto status = ParseBounded(bytes, parts.sessions.limits, message); !status.ok()) {
    return status;
  }
  if constexpr (requires { message.scene_id(); }) {
    if (auto status = caller->Authorize(name, message.scene_id()); !status.ok()) return status;
  }
  return caller;
}

// Finishes the call with `answer(message, caller)`, an absl::StatusOr of the response. `answer` may
// wait for the disk where `lane` is one, on whose thread it then runs, once the caller has a turn;
// where there is none it must not take long. A disk that has gone to sleep keeps a client without a
// deadline no longer than limits.transfer_idle_timeout: the call is cancelled, and what it asked
// for may still be done.
template <typename Request, typename Answer>
grpc::ServerUnaryReactor* AnswerUnaryOn(FairLane* lane, const ServiceParts& parts,
                                        grpc::CallbackServerContext* context,
                                        const grpc::ByteBuffer* request, grpc::ByteBuffer* response,
                                        Answer answer) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  const auto record =
      std::make_shared<CallRecord>(parts.sessions.counters, parts.logger, MethodOf<Request>());
  Request message;
  const auto caller = AdmitRequest(*context, parts, *request, message);
  if (!caller.ok()) {
    record->End(caller.status());
    reactor->Finish(ToGrpcStatus(caller.status()));
    return reactor;
  }
  const auto timer =
      lane ? IdleTimer::Start(context, parts.sessions.limits.transfer_idle_timeout) : nullptr;
  auto finish = [response, reactor, record, timer, message = std::move(message), caller = *caller,
                 answer = std::move(answer)] {
    const auto result = answer(message, caller);
    if (timer) timer->Stop();
    if (result.ok()) *response = ToBytes(*result);
    record->End(result.status());
    reactor->Finish(ToGrpcStatus(result.status()));
  };
  if (lane) {
    lane->Post(caller->identity().name, std::move(finish));
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
