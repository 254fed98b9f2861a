#include "render/gl/worker_health.h"

#include <algorithm>
#include <utility>

namespace penumbra::gl {

void WorkerHealth::AddFailure(std::string what) {
  {
    const std::lock_guard lock(mutex_);
    last_failure_ = std::move(what);
    if (!options_.now_ms) return;
    failures_ms_.push_back(options_.now_ms());
    if (failures_ms_.size() > kMaxFailures) failures_ms_.pop_front();
    if (is_degraded_ || RecentFailures() < kMaxFailures) return;
    is_degraded_ = true;
  }
  Tell(true);
}

void WorkerHealth::AddSuccess() {
  {
    const std::lock_guard lock(mutex_);
    if (!is_degraded_ || RecentFailures() >= kMaxFailures) return;
    is_degraded_ = false;
  }
  Tell(false);
}

bool WorkerHealth::TakesJobs() const {
  const std::lock_guard lock(mutex_);
  return !is_degraded_ || RecentFailures() < kMaxFailures;
}

bool WorkerHealth::is_degraded() const {
  const std::lock_guard lock(mutex_);
  return is_degraded_;
}

std::string WorkerHealth::reason() const {
  const std::lock_guard lock(mutex_);
  return is_degraded_ ? last_failure_ : std::string();
}

size_t WorkerHealth::RecentFailures() const {
  const double now_ms = options_.now_ms();
  return static_cast<size_t>(std::ranges::count_if(
      failures_ms_, [&](double failed_ms) { return now_ms - failed_ms < kWindowMs; }));
}

void WorkerHealth::Tell(bool is_degraded) const {
  if (options_.on_change) options_.on_change(is_degraded);
}

}  // namespace penumbra::gl
