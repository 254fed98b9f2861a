// Wall time by the clock that a computation is given.
#pragma once

#include "render/technique/technique.h"

namespace penumbra {

// Measures wall time from its construction or last restart; 0 without a clock.
class Stopwatch {
 public:
  explicit Stopwatch(const MonotonicClock& now_ms) : now_ms_(now_ms), start_(Now()) {}
  double ElapsedMs() const { return Now() - start_; }
  void Restart() { start_ = Now(); }

 private:
  double Now() const { return now_ms_ ? now_ms_() : 0; }

  const MonotonicClock& now_ms_;
  double start_;
};

}  // namespace penumbra
