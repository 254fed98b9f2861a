#include "server/read_delay.h"

#include <grpc/impl/codegen/grpc_types.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <climits>
#include <condition_variable>
#include <mutex>

#include "grpcpp/channel.h"
#include "grpcpp/create_channel_posix.h"
#include "grpcpp/generic/async_generic_service.h"
#include "grpcpp/generic/generic_stub.h"
#include "grpcpp/server.h"
#include "grpcpp/server_builder.h"
#include "grpcpp/server_posix.h"
#include "render/math/hand_over.h"
#include "server/delay_trend.h"
#include "server/transport.h"

namespace penumbra {
namespace {

// A message takes about a tenth of what a commit does. Requests that come more slowly than these
// are not what keeps the processor busy.
constexpr uint64_t kRequestsForOne = 8;
constexpr std::chrono::milliseconds kMostForThem{20};
// Between messages.
constexpr std::chrono::milliseconds kInterval{5};
// Where so many have not come for so long they are few.
constexpr std::chrono::milliseconds kFewSince{50};
constexpr ReadDelay::Clock::duration kLongest = std::chrono::seconds(1);

// Of 2^64.
constexpr uint64_t kGoldenRatio = 0x9E3779B97F4A7C15u;
constexpr uint64_t kBlock = 64;

// SplitMix64, of Steele, Lea and Flood 2014.
uint64_t Mixed(uint64_t number) {
  number *= kGoldenRatio;
  number = (number ^ number >> 30) * 0xBF58476D1CE4E5B9u;
  number = (number ^ number >> 27) * 0x94D049BB133111EBu;
  return number ^ number >> 31;
}

grpc::ByteBuffer OneByte() {
  const grpc::Slice slice("?", 1);
  return grpc::ByteBuffer(&slice, 1);
}

}  // namespace

// The connection to ourselves: its one call, from both ends.
class ReadDelay::Loop final : public grpc::CallbackGenericService {
 public:
  static std::unique_ptr<Loop> Open() {
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends.data()) != 0) {
      return nullptr;
    }
    return std::unique_ptr<Loop>(new Loop(ends[0], ends[1]));
  }

  ~Loop() override {
    if (!server_) return;
    sender_.End();
    server_->Shutdown(std::chrono::system_clock::now());
  }

  void Send(Clock::time_point now) {
    {
      std::lock_guard lock(mutex_);
      if (is_broken_ || trend_.is_under_way() || !is_written_ || now - trend_.sent() < kInterval) {
        return;
      }
      is_written_ = false;
      trend_.OnSent(now);
    }
    sender_.Send();
  }

  void OnAdmission(bool is_refused) {
    std::lock_guard lock(mutex_);
    trend_.OnAdmission(is_refused, Clock::now());
  }

  Clock::duration Now() const {
    std::lock_guard lock(mutex_);
    return trend_.Now(Clock::now());
  }

 private:
  class Sender final : public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
   public:
    explicit Sender(Loop& loop) : loop_(loop) {}

    void Begin(grpc::GenericStub& stub) {
      stub.PrepareBidiStreamingCall(&context_, "/penumbra/ReadDelay", {}, this);
      AddHold();  // for what Send sends
      StartCall();
    }
    void Send() {
      callbacks_.Give();
      StartWrite(&message_);
    }
    void End() {
      context_.TryCancel();
      RemoveHold();
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return is_done_; });
    }

    void OnWriteDone(bool ok) override {
      callbacks_.Take();
      ok ? loop_.OnWritten() : loop_.OnBroken();
    }
    void OnDone(const grpc::Status&) override {
      callbacks_.Take();
      loop_.OnBroken();
      std::lock_guard lock(mutex_);
      is_done_ = true;
      changed_.notify_all();
    }

   private:
    Loop& loop_;
    HandOver callbacks_;
    grpc::ClientContext context_;
    const grpc::ByteBuffer message_ = OneByte();
    std::mutex mutex_;
    std::condition_variable changed_;
    bool is_done_ = false;
  };

  class Receiver final : public grpc::ServerGenericBidiReactor {
   public:
    explicit Receiver(Loop& loop) : loop_(loop) { StartRead(&message_); }

    void OnReadDone(bool ok) override {
      callbacks_.Take();
      if (!ok) {
        loop_.OnBroken();
        return Finish(grpc::Status::OK);
      }
      loop_.OnCame();
      callbacks_.Give();
      StartRead(&message_);
    }
    void OnDone() override { delete this; }

   private:
    Loop& loop_;
    HandOver callbacks_;
    grpc::ByteBuffer message_;
  };

  Loop(int client_end, int server_end) : sender_(*this) {
    grpc::ServerBuilder builder;
    LeaveOutReflection(builder);
    // Nobody answers pings while the processor does not keep up.
    builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, INT_MAX);
    builder.RegisterCallbackGenericService(this);
    server_ = builder.BuildAndStart();
    if (!server_) {
      is_broken_ = true;
      ::close(client_end);
      ::close(server_end);
      return;
    }
    grpc::AddInsecureChannelFromFd(server_.get(), server_end);
    grpc::GenericStub stub(grpc::CreateInsecureChannelFromFd("", client_end));
    sender_.Begin(stub);
  }

  grpc::ServerGenericBidiReactor* CreateReactor(grpc::GenericCallbackServerContext*) override {
    return new Receiver(*this);
  }

  // The call has ended, if not by the destructor: nothing is measured any more.
  void OnBroken() {
    std::lock_guard lock(mutex_);
    is_broken_ = true;
    trend_.OnLost();
  }
  void OnWritten() {
    std::lock_guard lock(mutex_);
    is_written_ = true;
  }
  void OnCame() {
    std::lock_guard lock(mutex_);
    trend_.OnCame(Clock::now());
  }

  mutable std::mutex mutex_;  // guards the next three
  DelayTrend trend_;
  bool is_written_ = true, is_broken_ = false;
  Sender sender_;
  std::unique_ptr<grpc::Server> server_;
};

ReadDelay::ReadDelay() : loop_(Loop::Open()) {}
ReadDelay::~ReadDelay() = default;

double ReadDelay::OnRequest() {
  const uint64_t number = ++requests_;
  if (loop_ && number % kRequestsForOne == 0) {
    const auto now = Clock::now();
    if (now - eighth_.exchange(now) <= kMostForThem) {
      many_ = now;
      loop_->Send(now);
    }
  }
  // Multiples of the golden ratio, which are spread evenly, begun somewhere else in each block:
  // where clients take turns, one would otherwise draw nearly the same number for a long time.
  const uint64_t lot = number * kGoldenRatio + Mixed(number / kBlock);
  return static_cast<double>(lot >> 11) * 0x1p-53;
}

void ReadDelay::OnAdmission(bool is_refused) {
  if (loop_) loop_->OnAdmission(is_refused);
}

ReadDelay::Clock::duration ReadDelay::Now() const {
  if (!loop_) return Clock::duration::zero();
  const auto delay = loop_->Now();
  // Many came a while ago, and few since: they may wait with the message, but not for ever.
  const bool is_past = Clock::now() - many_.load() > kFewSince + std::min(delay, kLongest);
  return is_past ? Clock::duration::zero() : delay;
}

}  // namespace penumbra
