// Cancels a call whose client has stopped sending, or reading.
//
//   timer_(IdleTimer::Start(context, limits.transfer_idle_timeout))
//   timer_->Touch();   // whenever something has arrived, or gone out
//   timer_->Stop();    // before the context is gone
#pragma once

#include <chrono>
#include <memory>
#include <mutex>

#include "grpcpp/alarm.h"
#include "grpcpp/server_context.h"

namespace penumbra {

class IdleTimer : public std::enable_shared_from_this<IdleTimer> {
 public:
  static std::shared_ptr<IdleTimer> Start(grpc::CallbackServerContext* context,
                                          std::chrono::milliseconds timeout);
  void Touch();
  void Stop();

 private:
  IdleTimer(grpc::CallbackServerContext* context, std::chrono::milliseconds timeout)
      : timeout_(timeout), context_(context) {}
  void Arm(std::chrono::milliseconds delay);
  void OnAlarm();

  const std::chrono::milliseconds timeout_;
  std::mutex mutex_;
  grpc::CallbackServerContext* context_;  // null once stopped
  std::chrono::steady_clock::time_point touched_ = std::chrono::steady_clock::now();
  std::unique_ptr<grpc::Alarm> alarm_;
};

}  // namespace penumbra
