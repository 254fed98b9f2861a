// The peer of the service suite: a plain gRPC server that sends back what it gets, over loopback.
//
//   EchoPeer echo;
//   double round_trip_ms = echo.RoundTripMs(message);
#pragma once

#include <memory>

#include "grpcpp/channel.h"
#include "grpcpp/client_context.h"
#include "grpcpp/server.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/sync_stream.h"
#include "tests/support/echo_service.h"

namespace penumbra::bench {

// One open bidirectional stream; the server is gRPC's callback API, the client blocks.
class EchoPeer {
 public:
  EchoPeer();
  ~EchoPeer();

  // From the message's writing until it is back whole.
  double RoundTripMs(const grpc::ByteBuffer& message);

 private:
  testing::EchoService service_;
  std::unique_ptr<grpc::Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<grpc::ByteBuffer, grpc::ByteBuffer>> stream_;
};

}  // namespace penumbra::bench
