#include "server/service/idle_timer.h"

namespace penumbra {

std::shared_ptr<IdleTimer> IdleTimer::Start(grpc::CallbackServerContext* context,
                                            std::chrono::milliseconds timeout) {
  std::shared_ptr<IdleTimer> timer(new IdleTimer(context, timeout));
  std::lock_guard lock(timer->mutex_);
  timer->Arm(timeout);
  return timer;
}

void IdleTimer::Arm(std::chrono::milliseconds delay) {
  alarm_.Set(std::chrono::system_clock::now() + delay,
             [self = shared_from_this()](bool has_elapsed) {
               if (has_elapsed) self->OnAlarm();
             });
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
  alarm_.Cancel();
}

}  // namespace penumbra
