// Times, as a load prints them.
#pragma once

#include <cstdio>
#include <vector>

#include "tests/bench/bench.h"

namespace penumbra::load {

using bench::Percentile;

// "answer.p50_ms 0.31", and so on.
inline void PrintPercentiles(const char* name, const std::vector<double>& ms) {
  std::printf("%s.count %zu\n%s.p50_ms %.3f\n%s.p99_ms %.3f\n%s.p999_ms %.3f\n%s.max_ms %.3f\n",
              name, ms.size(), name, Percentile(ms, 0.5), name, Percentile(ms, 0.99), name,
              Percentile(ms, 0.999), name, Percentile(ms, 1.0));
}

}  // namespace penumbra::load
