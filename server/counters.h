// What the server has done since its start, counted from many threads.
#pragma once

#include <atomic>
#include <cstdint>

namespace penumbra {

struct ServerCounters {
  std::atomic<uint64_t> sessions_made{0};
  std::atomic<uint64_t> open_sessions{0};
  std::atomic<uint64_t> open_subscriptions{0};
  std::atomic<uint64_t> commits{0};
  std::atomic<uint64_t> artifacts_encoded{0};
  std::atomic<uint64_t> updates_sent{0};
};

}  // namespace penumbra
