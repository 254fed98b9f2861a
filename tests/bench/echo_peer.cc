#include "tests/bench/echo_peer.h"

#include <string>

#include "grpcpp/create_channel.h"
#include "grpcpp/server_builder.h"
#include "tests/bench/bench.h"

namespace penumbra::bench {
namespace {

constexpr char kMethod[] = "/penumbra.bench.Echo/Echo";

}  // namespace

EchoPeer::EchoPeer() {
  grpc::ServerBuilder builder;
  int port = 0;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  builder.RegisterCallbackGenericService(&service_);
  server_ = builder.BuildAndStart();
  channel_ =
      grpc::CreateChannel("127.0.0.1:" + std::to_string(port), grpc::InsecureChannelCredentials());
  const grpc::internal::RpcMethod method(kMethod, grpc::internal::RpcMethod::BIDI_STREAMING);
  stream_.reset(
      grpc::internal::ClientReaderWriterFactory<grpc::ByteBuffer, grpc::ByteBuffer>::Create(
          channel_.get(), method, &context_));
}

EchoPeer::~EchoPeer() {
  stream_->WritesDone();
  stream_->Finish();
  server_->Shutdown();
}

double EchoPeer::RoundTripMs(const grpc::ByteBuffer& message) {
  grpc::ByteBuffer back;
  const double start = NowMs();
  stream_->Write(message);
  stream_->Read(&back);
  return NowMs() - start;
}

}  // namespace penumbra::bench
