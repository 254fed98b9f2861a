// Times, as a load prints them.
#pragma once

#include <algorithm>
#include <cstdio>
#include <vector>

namespace penumbra::load {

inline double Percentile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0;
  const auto rank = static_cast<size_t>(fraction * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rank),
                   values.end());
  return values[rank];
}

// "answer.p50_ms 0.31", and so on.
inline void PrintPercentiles(const char* name, const std::vector<double>& ms) {
  std::printf("%s.count %zu\n%s.p50_ms %.3f\n%s.p99_ms %.3f\n%s.p999_ms %.3f\n%s.max_ms %.3f\n",
              name, ms.size(), name, Percentile(ms, 0.5), name, Percentile(ms, 0.99), name,
              Percentile(ms, 0.999), name, Percentile(ms, 1.0));
}

}  // namespace penumbra::load
