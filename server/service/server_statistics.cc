#include "server/service/server_statistics.h"

namespace penumbra {

v1::ServerStatistics StatisticsOf(const ServiceParts& parts) {
  const ServerCounters& counters = parts.sessions.counters;
  const EngineStatistics engine = parts.engine.statistics();
  v1::ServerStatistics statistics;
  statistics.set_open_sessions(counters.open_sessions);
  statistics.set_open_subscriptions(counters.open_subscriptions);
  statistics.set_commits(counters.commits);
  statistics.set_artifacts_computed(engine.artifacts_published);
  statistics.set_jobs_started(engine.jobs_started);
  statistics.set_jobs_failed(engine.jobs_failed);
  statistics.set_artifacts_encoded(counters.artifacts_encoded);
  statistics.set_updates_sent(counters.updates_sent);
  statistics.set_updates_skipped(counters.updates_skipped);
  statistics.set_sent_bytes(counters.sent_bytes);
  statistics.set_open_calls(counters.open_calls);
  statistics.set_blobs(parts.sessions.blobs.blob_count());
  statistics.set_blob_bytes(parts.sessions.blobs.blob_bytes());
  return statistics;
}

uint64_t UptimeMs(const ServiceParts& parts) {
  using std::chrono::duration_cast, std::chrono::milliseconds, std::chrono::steady_clock;
  const auto uptime = duration_cast<milliseconds>(steady_clock::now() - parts.started);
  return static_cast<uint64_t>(uptime.count());
}

}  // namespace penumbra
