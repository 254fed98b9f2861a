// A unary call from bytes to bytes.
#pragma once

#include <utility>

#include "absl/status/statusor.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/byte_buffer.h"
#include "proto/convert/status_convert.h"
#include "render/engine/worker_pool.h"
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

// The same on a thread of `lane`, where `answer` may wait for the disk; at once where there is none.
// `answer` is kept until then.
template <typename Request, typename Answer>
grpc::ServerUnaryReactor* AnswerUnaryOn(WorkerPool::Lane* lane,
                                        grpc::CallbackServerContext* context,
                                        const ServerLimits& limits, const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response, Answer answer) {
  if (!lane) return AnswerUnary<Request>(context, limits, request, response, std::move(answer));
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  Request message;
  if (auto status = ParseBounded(*request, limits, message); !status.ok()) {
    reactor->Finish(ToGrpcStatus(status));
    return reactor;
  }
  lane->Post([reactor, response, message = std::move(message), answer = std::move(answer)] {
    const auto result = answer(message);
    if (result.ok()) *response = ToBytes(*result);
    reactor->Finish(ToGrpcStatus(result.status()));
  });
  return reactor;
}

}  // namespace penumbra
