// A bidirectional call on gRPC's own threads: no thread of its own, so that hundreds of them cost a
// load little. Messages go out in their order; each that comes is handed to a function.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <utility>

#include "grpcpp/client_context.h"
#include "grpcpp/support/client_callback.h"

namespace penumbra::load {

template <typename Request, typename Response>
class MessageStream final : public grpc::ClientBidiReactor<Request, Response> {
 public:
  using OnMessage = std::function<void(const Response&)>;
  using OnEnd = std::function<void(const grpc::Status&)>;

  MessageStream(OnMessage on_message, OnEnd on_end)
      : on_message_(std::move(on_message)), on_end_(std::move(on_end)) {}

  // Ends the call and waits for that.
  ~MessageStream() override {
    context_.TryCancel();
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] { return is_done_; });
  }

  // `call(context, this)` begins the call.
  template <typename Call>
  void Begin(Call call) {
    call(&context_, this);
    this->AddHold();  // for what is sent from outside of the call's own functions
    this->StartRead(&response_);
    this->StartCall();
  }

  void Send(Request request) {
    std::lock_guard lock(mutex_);
    requests_.push_back(std::move(request));
    if (requests_.size() == 1 && !is_over_) this->StartWrite(&requests_.front());
  }

  void OnReadDone(bool ok) override {
    if (!ok) {
      std::lock_guard lock(mutex_);
      is_over_ = true;
      return this->RemoveHold();
    }
    on_message_(response_);
    this->StartRead(&response_);
  }
  void OnWriteDone(bool ok) override {
    std::lock_guard lock(mutex_);
    requests_.pop_front();
    if (ok && !is_over_ && !requests_.empty()) this->StartWrite(&requests_.front());
  }
  void OnDone(const grpc::Status& status) override {
    on_end_(status);
    std::lock_guard lock(mutex_);
    is_done_ = true;
    done_.notify_all();
  }

 private:
  const OnMessage on_message_;
  const OnEnd on_end_;
  grpc::ClientContext context_;
  Response response_;
  std::mutex mutex_;
  std::condition_variable done_;
  std::deque<Request> requests_;  // the first is being written
  bool is_over_ = false;          // nothing more can be sent
  bool is_done_ = false;
};

}  // namespace penumbra::load
