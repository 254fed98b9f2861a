#include "server/read_delay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "grpcpp/create_channel.h"
#include "grpcpp/generic/async_generic_service.h"
#include "grpcpp/generic/generic_stub.h"
#include "grpcpp/server.h"
#include "grpcpp/server_builder.h"

namespace penumbra::testing {
namespace {

using std::chrono::milliseconds;
using Clock = ReadDelay::Clock;

// Calls that hold up gRPC's threads until they are let go, as a processor without time would.
class HeldThreads {
 public:
  HeldThreads() {
    grpc::ServerBuilder builder;
    int port = 0;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterCallbackGenericService(&service_);
    server_ = builder.BuildAndStart();
    grpc::GenericStub stub(grpc::CreateChannel("127.0.0.1:" + std::to_string(port),
                                               grpc::InsecureChannelCredentials()));
    for (Caller& caller : callers_) {
      stub.PrepareUnaryCall(&caller.context, "/hold", {}, &caller.request, &caller.response,
                            &caller);
      caller.StartCall();
    }
    // Until all that there are are held: no more come.
    int before = -1;
    for (int now = 0; now != before || now == 0; now = service_.held()) {
      before = now;
      std::this_thread::sleep_for(milliseconds(200));
    }
  }
  ~HeldThreads() {
    LetGo();
    for (Caller& caller : callers_) caller.Await();
    server_->Shutdown();
  }
  void LetGo() { service_.LetGo(); }

 private:
  class Service final : public grpc::CallbackGenericService {
   public:
    grpc::ServerGenericBidiReactor* CreateReactor(grpc::GenericCallbackServerContext*) override {
      struct Reactor final : grpc::ServerGenericBidiReactor {
        Reactor() { Finish(grpc::Status::OK); }
        void OnDone() override { delete this; }
      };
      {
        std::unique_lock lock(mutex_);
        ++held_;
        changed_.wait(lock, [this] { return is_over_; });
      }
      return new Reactor;
    }
    int held() const {
      std::lock_guard lock(mutex_);
      return held_;
    }
    void LetGo() {
      std::lock_guard lock(mutex_);
      is_over_ = true;
      changed_.notify_all();
    }

   private:
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    int held_ = 0;
    bool is_over_ = false;
  };

  class Caller final : public grpc::ClientUnaryReactor {
   public:
    void OnDone(const grpc::Status&) override {
      std::lock_guard lock(mutex_);
      is_done_ = true;
      changed_.notify_all();
    }
    void Await() {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return is_done_; });
    }

    grpc::ClientContext context;
    grpc::ByteBuffer request, response;

   private:
    std::mutex mutex_;
    std::condition_variable changed_;
    bool is_done_ = false;
  };

  Service service_;
  std::unique_ptr<grpc::Server> server_;
  std::vector<Caller> callers_ = std::vector<Caller>(64);
};

// A message is sent, and has come when this returns, if it can.
void Ask(ReadDelay& delay) {
  std::this_thread::sleep_for(milliseconds(10));
  for (int i = 0; i < 16; ++i) delay.OnRequest();
  std::this_thread::sleep_for(milliseconds(10));
}

TEST(ReadDelayTest, IsNoneWhereNobodyAsks) {
  ReadDelay delay;
  EXPECT_EQ(delay.Now(), Clock::duration::zero());
  for (int i = 0; i < 7; ++i) delay.OnRequest();
  std::this_thread::sleep_for(milliseconds(20));
  EXPECT_EQ(delay.Now(), Clock::duration::zero()) << "seven requests are no load";
}

TEST(ReadDelayTest, IsNoneWhereFewAsk) {
  ReadDelay delay;
  HeldThreads held;
  for (int i = 0; i < 32; ++i) {
    delay.OnRequest();
    std::this_thread::sleep_for(milliseconds(5));
  }
  EXPECT_EQ(delay.Now(), Clock::duration::zero()) << "200 a second are no load";
}

TEST(ReadDelayTest, IsNoneWhereThereIsTime) {
  ReadDelay delay;
  int found = 0;
  for (int i = 0; i < 21; ++i) {
    Ask(delay);
    found += delay.Now() > Clock::duration::zero();
  }
  EXPECT_LT(found, 10) << "on a machine that does other things besides";
}

TEST(ReadDelayTest, GrowsWhileNobodyReadsAndIsGoneAgain) {
  ReadDelay delay;
  Ask(delay);
  {
    HeldThreads held;
    Ask(delay);
    std::this_thread::sleep_for(milliseconds(100));
    const auto some = delay.Now();
    EXPECT_GE(some, milliseconds(100)) << "what is still under way counts";
    std::this_thread::sleep_for(milliseconds(100));
    EXPECT_GE(delay.Now(), some + milliseconds(90));
    held.LetGo();
    std::this_thread::sleep_for(milliseconds(50));
    EXPECT_GE(delay.Now(), some) << "it was long, and is known for some moments";
  }
  std::this_thread::sleep_for(milliseconds(1'500));
  EXPECT_EQ(delay.Now(), Clock::duration::zero());
}

TEST(ReadDelayTest, LotsAreSpreadEvenly) {
  ReadDelay delay;
  std::vector<double> lots;
  for (int i = 0; i < 1'000; ++i) lots.push_back(delay.OnRequest());
  std::ranges::sort(lots);
  for (size_t i = 0; i < lots.size(); ++i) EXPECT_NEAR(lots[i], i / 1e3, 0.01);
}

}  // namespace
}  // namespace penumbra::testing
