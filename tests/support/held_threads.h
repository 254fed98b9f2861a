// gRPC's threads held up in this process, as by a processor that does not get to them.
//
//   HeldThreads held;   // returns when all of them are
//   …
//   held.LetGo();
#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
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
    const grpc::Slice byte("?", 1);
    for (Caller& caller : callers_) {
      caller.request = grpc::ByteBuffer(&byte, 1);
      stub.PrepareUnaryCall(&caller.context, "/hold", {}, &caller.request, &caller.response,
                            &caller);
      caller.StartCall();
    }
    // Until all that there are are held: no more come.
    int before = 0;
    for (int unchanged = 0; unchanged < 3;) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      const int now = service_.held();
      unchanged = now == before && now > 0 ? unchanged + 1 : 0;
      before = now;
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

}  // namespace penumbra::testing
