// How many light samples a first pass can take within a time budget, learned from the first passes
// before it.
#pragma once

#include <algorithm>
#include <cstdint>

namespace penumbra {

class FirstPassPace {
 public:
  // Samples that should take `budget_ms`, at least 1 and at most four times as many as last time;
  // `untried` where nothing is known yet. What a pass costs apart from its samples is learned in a
  // few steps: each corrects what the one before was off by.
  uint32_t Samples(double budget_ms, uint32_t untried) const {
    if (samples_ == 0 || !(ms_ > 0)) return untried;
    const double fitting = samples_ * (budget_ms / ms_);
    return static_cast<uint32_t>(std::clamp(fitting, 1.0, 4.0 * samples_));
  }

  void Learn(uint32_t samples, double ms) {
    samples_ = samples;
    ms_ = ms;
  }

 private:
  uint32_t samples_ = 0;  // of the last first pass
  double ms_ = 0;         // that it took
};

}  // namespace penumbra
