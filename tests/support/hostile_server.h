// A server that speaks the protocol as far as a test lets it, to see what clients do about it.
//
//   HostileServer server([](HostileServer::Stream& stream, int) { return Listen(stream); });
//   auto engine = RemoteEngine::Connect({.address = server.address()});
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "grpcpp/security/server_credentials.h"
#include "grpcpp/server.h"
#include "grpcpp/server_builder.h"
#include "penumbra/v1/service.grpc.pb.h"

namespace penumbra::testing {

// Welcomes everybody, and then does what it is told to, session by session. Who derives from it may
// answer other calls.
class HostileServer : public v1::PenumbraService::Service {
 public:
  using Stream = grpc::ServerReaderWriter<v1::SessionResponse, v1::SessionRequest>;
  using Act = std::function<grpc::Status(Stream& stream, int session)>;

  explicit HostileServer(Act act) : act_(std::move(act)) {
    grpc::ServerBuilder builder;
    int port = 0;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
    address_ = "127.0.0.1:" + std::to_string(port);
  }
  ~HostileServer() override { server_->Shutdown(std::chrono::system_clock::now()); }

  const std::string& address() const { return address_; }
  int sessions() const { return sessions_; }

  grpc::Status GetServerInfo(grpc::ServerContext*, const v1::GetServerInfoRequest*,
                             v1::GetServerInfoResponse*) override {
    return grpc::Status::OK;
  }
  grpc::Status Session(grpc::ServerContext*, Stream* stream) override {
    v1::SessionRequest request;
    stream->Read(&request);
    v1::SessionResponse welcome;
    welcome.mutable_welcome()->set_protocol_version(1);
    welcome.mutable_welcome()->set_participant_id("you");
    stream->Write(welcome);
    return act_(*stream, ++sessions_);
  }

 private:
  const Act act_;
  std::unique_ptr<grpc::Server> server_;
  std::string address_;
  std::atomic<int> sessions_ = 0;
};

// Until the client goes.
inline grpc::Status Listen(HostileServer::Stream& stream) {
  v1::SessionRequest request;
  while (stream.Read(&request)) {
  }
  return grpc::Status::OK;
}

}  // namespace penumbra::testing
