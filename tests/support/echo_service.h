// A plain gRPC server's side of what services are held against: it sends back what it gets.
#pragma once

#include "grpcpp/generic/async_generic_service.h"
#include "grpcpp/support/byte_buffer.h"

namespace penumbra::testing {

// Streams of any method.
class EchoService final : public grpc::CallbackGenericService {
 private:
  class Stream final : public grpc::ServerGenericBidiReactor {
   public:
    Stream() { StartRead(&message_); }
    void OnReadDone(bool ok) override {
      if (ok) return StartWrite(&message_);
      Finish(grpc::Status::OK);
    }
    void OnWriteDone(bool ok) override {
      if (ok) return StartRead(&message_);
      Finish(grpc::Status::CANCELLED);
    }
    void OnDone() override { delete this; }

   private:
    grpc::ByteBuffer message_;
  };

  grpc::ServerGenericBidiReactor* CreateReactor(grpc::GenericCallbackServerContext*) override {
    return new Stream();
  }
};

}  // namespace penumbra::testing
