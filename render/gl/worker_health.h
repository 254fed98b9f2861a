// Whether a GL worker can be relied on: after three failures within ten minutes it is left alone,
// until one of them is longer ago.
//
//   WorkerHealth health({.now_ms = NowMs});
//   health.AddFailure("the GL context is lost");
//   if (!health.TakesJobs()) …   // compute without GL
#pragma once

#include <deque>
#include <functional>
#include <mutex>
#include <string>

namespace penumbra::gl {

struct HealthOptions {
  // Milliseconds on a clock that only goes forward. Null: failures are forgotten at once.
  std::function<double()> now_ms = nullptr;
  // Told when that changes which is_degraded() tells; on the worker's thread.
  std::function<void(bool is_degraded)> on_change = nullptr;
};

// Any thread may ask.
class WorkerHealth {
 public:
  static constexpr size_t kMaxFailures = 3;
  static constexpr double kWindowMs = 10 * 60'000.0;

  explicit WorkerHealth(HealthOptions options) : options_(std::move(options)) {}

  void AddFailure(std::string what);
  void AddSuccess();

  // False: there were kMaxFailures within the last kWindowMs.
  bool TakesJobs() const;
  // From when it takes no jobs on until one succeeds again.
  bool is_degraded() const;
  // What failed last; empty unless degraded.
  std::string reason() const;

 private:
  size_t RecentFailures() const;  // with the lock held
  void Tell(bool is_degraded) const;

  const HealthOptions options_;
  mutable std::mutex mutex_;
  std::deque<double> failures_ms_;  // the last kMaxFailures, oldest first
  std::string last_failure_;
  bool is_degraded_ = false;
};

}  // namespace penumbra::gl
