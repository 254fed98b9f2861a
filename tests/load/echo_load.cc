#include "tests/load/echo_load.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "grpcpp/create_channel.h"
#include "grpcpp/generic/async_generic_service.h"
#include "grpcpp/impl/codegen/client_callback.h"
#include "grpcpp/security/credentials.h"
#include "grpcpp/security/server_credentials.h"
#include "grpcpp/server.h"
#include "grpcpp/server_builder.h"
#include "grpcpp/support/channel_arguments.h"
#include "grpcpp/support/sync_stream.h"

namespace penumbra::load {
namespace {

using Clock = std::chrono::steady_clock;

constexpr char kMethod[] = "/echo.Echo/Talk";
// What a commit of one instance takes.
constexpr size_t kMessageBytes = 160;

class EchoReactor final : public grpc::ServerGenericBidiReactor {
 public:
  EchoReactor() { StartRead(&message_); }
  void OnReadDone(bool ok) override {
    if (!ok) return Finish(grpc::Status::OK);
    StartWrite(&message_);
  }
  void OnWriteDone(bool ok) override {
    if (!ok) return Finish(grpc::Status::CANCELLED);
    StartRead(&message_);
  }
  void OnDone() override { delete this; }

 private:
  grpc::ByteBuffer message_;
};

class EchoService final : public grpc::CallbackGenericService {
  grpc::ServerGenericBidiReactor* CreateReactor(grpc::GenericCallbackServerContext*) override {
    return new EchoReactor;
  }
};

// Its answers come in the order of its messages.
class EchoClient {
 public:
  explicit EchoClient(const std::string& address) {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    channel_ = grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
    const grpc::internal::RpcMethod method(kMethod, grpc::internal::RpcMethod::BIDI_STREAMING,
                                           channel_);
    stream_.reset(
        grpc::internal::ClientReaderWriterFactory<grpc::ByteBuffer, grpc::ByteBuffer>::Create(
            channel_.get(), method, &context_));
    reader_ = std::thread([this] { Read(); });
  }
  ~EchoClient() {
    stream_->WritesDone();
    reader_.join();
    stream_->Finish();
  }

  void Send(const grpc::ByteBuffer& message, Clock::time_point due) {
    {
      std::lock_guard lock(mutex_);
      due_.push_back(due);
    }
    stream_->Write(message);
  }
  std::vector<double> TakeTimes() {
    std::lock_guard lock(mutex_);
    return std::move(times_ms_);
  }

 private:
  void Read() {
    grpc::ByteBuffer message;
    while (stream_->Read(&message)) {
      const auto now = Clock::now();
      std::lock_guard lock(mutex_);
      const std::chrono::duration<double, std::milli> time = now - due_.at(times_ms_.size());
      times_ms_.push_back(time.count());
    }
  }

  std::shared_ptr<grpc::Channel> channel_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<grpc::ByteBuffer, grpc::ByteBuffer>> stream_;
  std::mutex mutex_;
  std::vector<Clock::time_point> due_;
  std::vector<double> times_ms_;
  std::thread reader_;
};

}  // namespace

std::vector<double> EchoLoad(int clients, double rate, double seconds) {
  EchoService service;
  grpc::ServerBuilder builder;
  int port = 0;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  builder.RegisterCallbackGenericService(&service);
  const auto server = builder.BuildAndStart();
  const std::string bytes(kMessageBytes, 'e');
  const grpc::Slice slice(bytes);
  const grpc::ByteBuffer message(&slice, 1);
  std::vector<std::unique_ptr<EchoClient>> all;
  for (int i = 0; i < clients; ++i) {
    all.push_back(std::make_unique<EchoClient>("127.0.0.1:" + std::to_string(port)));
  }
  const auto interval =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.0 / rate));
  const auto start = Clock::now() + std::chrono::milliseconds(500);
  for (int64_t i = 0; i < static_cast<int64_t>(rate * seconds); ++i) {
    const auto due = start + i * interval;
    std::this_thread::sleep_until(due);
    all[static_cast<size_t>(i) % all.size()]->Send(message, due);
  }
  std::this_thread::sleep_for(std::chrono::seconds(1));
  std::vector<double> times;
  for (const auto& client : all) {
    const auto some = client->TakeTimes();
    times.insert(times.end(), some.begin(), some.end());
  }
  all.clear();
  server->Shutdown(std::chrono::system_clock::now() + std::chrono::seconds(1));
  return times;
}

}  // namespace penumbra::load
