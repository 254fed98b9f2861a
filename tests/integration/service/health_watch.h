// Follows what a server's health service says of one service.
//
//   HealthWatch watch(client.channel(), "penumbra.v1.PenumbraService");
//   EXPECT_EQ(watch.Next(), HealthWatch::kServing);
#pragma once

#include <memory>
#include <string>

#include "grpcpp/channel.h"
#include "grpcpp/client_context.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/sync_stream.h"

namespace penumbra::testing {

class HealthWatch {
 public:
  // grpc.health.v1.HealthCheckResponse.ServingStatus.
  enum Status { kEnded = -1, kUnknown = 0, kServing = 1, kNotServing = 2, kServiceUnknown = 3 };

  HealthWatch(const std::shared_ptr<grpc::Channel>& channel, const std::string& service)
      : stream_(
            grpc::internal::ClientReaderWriterFactory<grpc::ByteBuffer, grpc::ByteBuffer>::Create(
                channel.get(),
                grpc::internal::RpcMethod("/grpc.health.v1.Health/Watch",
                                          grpc::internal::RpcMethod::BIDI_STREAMING),
                &context_)) {
    // HealthCheckRequest{service}: field 1, a text of less than 128 bytes.
    std::string request;
    if (!service.empty())
      request = "\x0a" + std::string(1, static_cast<char>(service.size())) + service;
    const grpc::Slice slice(request);
    stream_->Write(grpc::ByteBuffer(&slice, 1));
    stream_->WritesDone();
  }
  ~HealthWatch() {
    context_.TryCancel();
    stream_->Finish();
  }

  // The next word; waits for it.
  Status Next() {
    grpc::ByteBuffer answer;
    if (!stream_->Read(&answer)) return kEnded;
    grpc::Slice slice;
    if (!answer.DumpToSingleSlice(&slice).ok() || slice.size() == 0) return kUnknown;
    // HealthCheckResponse{status}: field 1, a number.
    return slice.size() == 2 && slice.begin()[0] == 8 ? static_cast<Status>(slice.begin()[1])
                                                      : kUnknown;
  }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<grpc::ByteBuffer, grpc::ByteBuffer>> stream_;
};

}  // namespace penumbra::testing
