// What the server has done since its start, counted from many threads.
//
//   ++counters.commits;
//   counters.encode_seconds.Observe(0.002);
//   counters.CountRefusal("STALE_BASE");
//
// GetServerInfo and the metrics (metrics/metrics_collector.h) read it. Nothing here is counted by
// scene or client: their names are not for everyone who may see metrics, and there is no bound on
// how many come by.
#pragma once

#include <prometheus/counter.h>
#include <prometheus/family.h>
#include <prometheus/histogram.h>

#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>

namespace penumbra {

struct ServerCounters {
  std::atomic<uint64_t> sessions_made{0};
  std::atomic<uint64_t> open_sessions{0};
  std::atomic<uint64_t> open_subscriptions{0};
  std::atomic<uint64_t> calls_made{0};
  std::atomic<uint64_t> open_calls{0};  // of PenumbraService, sessions included
  std::atomic<uint64_t> commits{0};
  std::atomic<uint64_t> artifacts_encoded{0};
  std::atomic<uint64_t> updates_sent{0};
  std::atomic<uint64_t> updates_skipped{0};  // newer ones took their place before they were sent
  std::atomic<uint64_t> sent_bytes{0};       // of sessions' messages, before HTTP/2
  // Subscriptions that found their artifact computed, and those that did not.
  std::atomic<uint64_t> cache_hits{0};
  std::atomic<uint64_t> cache_misses{0};

  prometheus::Histogram queue_seconds{Seconds()};           // of jobs, for a thread
  prometheus::Histogram encode_seconds{Seconds()};          // of artifacts
  prometheus::Histogram first_artifact_seconds{Seconds()};  // see JobReport
  prometheus::Histogram final_artifact_seconds{Seconds()};
  // Of each session once it has ended: how clients differ, without a series for each.
  prometheus::Histogram session_sent_bytes{Bytes()};
  prometheus::Histogram session_seconds{Seconds()};

  // Of a job with this technique, from its start to its last artifact.
  void ObserveCompute(std::string_view technique, double seconds);
  // Of a call that has ended. `method` and `code` are words of the protocol.
  void ObserveCall(const std::string& method, const std::string& code, double seconds);
  // A request that was refused or a job that failed; by the error's reason, or its code's name.
  void CountFailure(const std::string& reason);

  prometheus::Family<prometheus::Histogram> compute_seconds{
      "penumbra_job_compute_seconds", "Time that jobs ran, by technique", {}};
  prometheus::Family<prometheus::Histogram> call_seconds{
      "penumbra_call_seconds", "Time from a call's begin to its end, by method", {}};
  prometheus::Family<prometheus::Counter> calls{
      "penumbra_calls_total", "Calls that have ended, by method and gRPC status code", {}};
  prometheus::Family<prometheus::Counter> failures{
      "penumbra_failures_total", "Refused requests and failed jobs, by reason", {}};

 private:
  static prometheus::Histogram::BucketBoundaries Seconds();
  static prometheus::Histogram::BucketBoundaries Bytes();
};

}  // namespace penumbra
