// What an engine has done since it was made: for tests ("one job computed") and for server info.
#pragma once

#include <atomic>
#include <cstdint>

namespace penumbra {

struct EngineStatistics {
  uint64_t jobs_started = 0;
  uint64_t jobs_finished = 0;   // ran to a final artifact that was published
  uint64_t jobs_cancelled = 0;  // superseded, or nobody subscribed any more
  uint64_t jobs_failed = 0;
  uint64_t first_passes = 0;  // jobs of which at least one artifact was published
  uint64_t artifacts_published =
      0;  // coarse and final ones; each is counted once for all subscribers
  uint64_t unaffected_commits = 0;  // commit × artifact pairs that needed no computing
  uint64_t callbacks_run = 0;
};

// The same, counted from many threads.
struct EngineCounters {
  std::atomic<uint64_t> jobs_started{0};
  std::atomic<uint64_t> jobs_finished{0};
  std::atomic<uint64_t> jobs_cancelled{0};
  std::atomic<uint64_t> jobs_failed{0};
  std::atomic<uint64_t> first_passes{0};
  std::atomic<uint64_t> artifacts_published{0};
  std::atomic<uint64_t> unaffected_commits{0};
  std::atomic<uint64_t> callbacks_run{0};

  EngineStatistics Read() const {
    return {.jobs_started = jobs_started,
            .jobs_finished = jobs_finished,
            .jobs_cancelled = jobs_cancelled,
            .jobs_failed = jobs_failed,
            .first_passes = first_passes,
            .artifacts_published = artifacts_published,
            .unaffected_commits = unaffected_commits,
            .callbacks_run = callbacks_run};
  }
};

}  // namespace penumbra
