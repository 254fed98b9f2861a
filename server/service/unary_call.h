// A unary call from bytes to bytes.
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

// The same on a thread of `lane`, where `answer` may wait for the disk; at once where there is none.
// `answer` is kept until then.
template <typename Request, typename Answer>
grpc::ServerUnaryReactor* AnswerUnaryOn(WorkerPool::Lane* lane, const ServiceParts& parts,
                                        grpc::CallbackServerContext* context,
                                        const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response, Answer answer) {
  if (!lane) return AnswerUnary<Request>(parts, context, request, response, std::move(answer));
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  const auto record = std::make_shared<CallRecord>(parts.sessions.counters, parts.logger,
                                                   MethodOf<Request>());
  Request message;
  if (auto status = ParseBounded(*request, parts.sessions.limits, message); !status.ok()) {
    record->End(status);
    reactor->Finish(ToGrpcStatus(status));
    return reactor;
  }
  lane->Post([reactor, response, record, message = std::move(message),
              answer = std::move(answer)] {
    const auto result = answer(message);
    if (result.ok()) *response = ToBytes(*result);
    record->End(result.status());
    reactor->Finish(ToGrpcStatus(result.status()));
  });
  return reactor;
}

}  // namespace penumbra
