#include "tests/load/echo_load.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "grpcpp/generic/generic_stub.h"
#include "grpcpp/security/server_credentials.h"
#include "grpcpp/server.h"
#include "grpcpp/server_builder.h"
#include "tests/load/message_stream.h"
#include "tests/load/own_channel.h"
#include "tests/support/echo_service.h"

namespace penumbra::load {
namespace {

using Clock = std::chrono::steady_clock;

constexpr char kMethod[] = "/echo.Echo/Talk";
// What a commit of one instance takes.
constexpr size_t kMessageBytes = 160;

// Its answers come in the order of its messages.
class EchoClient {
 public:
  explicit EchoClient(const std::string& address) : stub_(OwnChannel(address)) {
    stream_.Begin([this](grpc::ClientContext* context, Stream* stream) {
      stub_.PrepareBidiStreamingCall(context, kMethod, {}, stream);
    });
  }

  void Send(const grpc::ByteBuffer& message, Clock::time_point due) {
    {
      std::lock_guard lock(mutex_);
      due_.push_back(due);
    }
    stream_.Send(message);
  }
  std::vector<double> TakeTimes() {
    std::lock_guard lock(mutex_);
    return std::move(times_ms_);
  }

 private:
  using Stream = MessageStream<grpc::ByteBuffer, grpc::ByteBuffer>;

  void Take() {
    const auto now = Clock::now();
    std::lock_guard lock(mutex_);
    const std::chrono::duration<double, std::milli> time = now - due_.at(times_ms_.size());
    times_ms_.push_back(time.count());
  }

  grpc::GenericStub stub_;
  std::mutex mutex_;
  std::vector<Clock::time_point> due_;
  std::vector<double> times_ms_;
  Stream stream_{[this](const grpc::ByteBuffer&) { Take(); }, [](const grpc::Status&) {}};
};

}  // namespace

std::vector<double> EchoLoad(int clients, double rate, double seconds) {
  testing::EchoService service;
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
