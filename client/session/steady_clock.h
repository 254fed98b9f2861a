// The one clock of the client: milliseconds, only going forward.
#pragma once

#include <chrono>

namespace penumbra {

inline double NowMs() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double, std::milli>(now).count();
}

}  // namespace penumbra
