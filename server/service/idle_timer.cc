#include "server/service/idle_timer.h"

#include <functional>
#include <utility>

#include "render/math/hand_over.h"

namespace penumbra {

std::shared_ptr<IdleTimer> IdleTimer::Start(grpc::CallbackServerContext* context,
                                            std::chrono::milliseconds timeout) {
  std::shared_ptr<IdleTimer> timer(new IdleTimer(context, timeout));
  std::lock_guard lock(timer->mutex_);
  timer->Arm(timeout);
  return timer;
}

void IdleTimer::Arm(std::chrono::milliseconds delay) {
  // gRPC hands the closure from the thread that sets an alarm to the one that it goes off on, and
  // keeps it as long as the alarm lives: so it must not keep the timer.
  static HandOver closures;
  std::function<void(bool)> go_off = [weak = weak_from_this()](bool has_elapsed) {
    closures.Take();
    const auto self = weak.lock();
    if (has_elapsed && self) self->OnAlarm();
  };
  const auto due = std::chrono::system_clock::now() + delay;
  // Another alarm each time: setting one anew would destroy the closure that is running.
  alarm_ = std::make_unique<grpc::Alarm>();
  closures.Give();
  alarm_->Set(due, std::move(go_off));
}

void IdleTimer::OnAlarm() {
  using std::chrono::duration_cast, std::chrono::milliseconds;
  std::lock_guard lock(mutex_);
  if (!context_) return;
  const auto idle = duration_cast<milliseconds>(std::chrono::steady_clock::now() - touched_);
  if (idle >= timeout_) {
    context_->TryCancel();
  } else {
    Arm(timeout_ - idle);
  }
}

void IdleTimer::Touch() {
  std::lock_guard lock(mutex_);
  touched_ = std::chrono::steady_clock::now();
}

void IdleTimer::Stop() {
  std::lock_guard lock(mutex_);
  context_ = nullptr;
  alarm_->Cancel();
}

}  // namespace penumbra
