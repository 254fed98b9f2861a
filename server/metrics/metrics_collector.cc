#include "server/metrics/metrics_collector.h"

#include <utility>

#include "server/server_identity.h"

namespace penumbra {
namespace {

using prometheus::ClientMetric;
using prometheus::MetricFamily;
using prometheus::MetricType;
using Families = std::vector<MetricFamily>;
using Labels = std::vector<ClientMetric::Label>;

ClientMetric Sample(MetricType type, double value, Labels labels = {}) {
  ClientMetric metric;
  metric.label = std::move(labels);
  (type == MetricType::Counter ? metric.counter.value : metric.gauge.value) = value;
  return metric;
}

void AddTo(Families& families, MetricType type, const char* name, const char* help, double value) {
  families.push_back({name, help, type, {Sample(type, value)}});
}

void AddCounter(Families& families, const char* name, const char* help, uint64_t value) {
  AddTo(families, MetricType::Counter, name, help, static_cast<double>(value));
}

void AddGauge(Families& families, const char* name, const char* help, double value) {
  AddTo(families, MetricType::Gauge, name, help, value);
}

void AddHistogram(Families& families, const char* name, const char* help,
                  const prometheus::Histogram& histogram) {
  families.push_back({name, help, MetricType::Histogram, {histogram.Collect()}});
}

template <typename Metric>
void AddFamily(Families& families, const prometheus::Family<Metric>& family) {
  for (MetricFamily& collected : family.Collect()) families.push_back(std::move(collected));
}

void AddServing(Families& f, const ServerCounters& c) {
  AddGauge(f, "penumbra_open_sessions", "Sessions open now", c.open_sessions);
  AddCounter(f, "penumbra_sessions_total", "Sessions opened", c.sessions_made);
  AddGauge(f, "penumbra_open_subscriptions", "Subscriptions open now", c.open_subscriptions);
  AddGauge(f, "penumbra_open_calls", "Calls under way, sessions included", c.open_calls);
  AddCounter(f, "penumbra_commits_total", "Commits accepted", c.commits);
  AddCounter(f, "penumbra_artifacts_encoded_total", "Artifacts encoded, once for all subscribers",
             c.artifacts_encoded);
  AddCounter(f, "penumbra_updates_sent_total", "Updates sent to the end", c.updates_sent);
  AddCounter(f, "penumbra_updates_skipped_total",
             "Updates that newer ones took the place of before they were sent", c.updates_skipped);
  AddCounter(f, "penumbra_sent_bytes_total", "Bytes of sessions' messages sent", c.sent_bytes);
  f.push_back(
      {"penumbra_artifact_cache_lookups_total",
       "Subscriptions that looked for their artifact in the cache, by result",
       MetricType::Counter,
       {Sample(MetricType::Counter, static_cast<double>(c.cache_hits), {{"result", "hit"}}),
        Sample(MetricType::Counter, static_cast<double>(c.cache_misses), {{"result", "miss"}})}});
  AddFamily(f, c.calls);
  AddFamily(f, c.call_seconds);
  AddFamily(f, c.failures);
  AddHistogram(f, "penumbra_session_sent_bytes", "Bytes sent to a client, at its session's end",
               c.session_sent_bytes);
  AddHistogram(f, "penumbra_session_seconds", "How long a session was open, at its end",
               c.session_seconds);
}

void AddComputing(Families& f, const ServerCounters& c, const EngineStatistics& engine) {
  AddCounter(f, "penumbra_jobs_started_total", "Jobs started", engine.jobs_started);
  f.push_back({"penumbra_jobs_total",
               "Jobs that have ended, by outcome",
               MetricType::Counter,
               {Sample(MetricType::Counter, static_cast<double>(engine.jobs_finished),
                       {{"outcome", "finished"}}),
                Sample(MetricType::Counter, static_cast<double>(engine.jobs_cancelled),
                       {{"outcome", "superseded"}}),
                Sample(MetricType::Counter, static_cast<double>(engine.jobs_failed),
                       {{"outcome", "failed"}})}});
  AddCounter(f, "penumbra_artifacts_computed_total", "Artifacts computed, coarse passes included",
             engine.artifacts_published);
  AddCounter(f, "penumbra_unaffected_commits_total",
             "Pairs of a commit and an artifact that needed no computing",
             engine.unaffected_commits);
  AddHistogram(f, "penumbra_job_queue_seconds", "Time that jobs waited for a thread",
               c.queue_seconds);
  AddFamily(f, c.compute_seconds);
  AddHistogram(f, "penumbra_encode_seconds", "Time to encode an artifact", c.encode_seconds);
  AddHistogram(f, "penumbra_first_artifact_seconds",
               "From the commit or subscription to the first artifact computed for it",
               c.first_artifact_seconds);
  AddHistogram(f, "penumbra_final_artifact_seconds",
               "From the commit or subscription to the final artifact computed for it",
               c.final_artifact_seconds);
}

void AddResults(Families& f, const MetricsGauges& gauges) {
  const ResultStatistics& results = gauges.results;
  f.push_back({"penumbra_result_lookups_total",
               "Final artifacts that were looked for before computing them, by where they were",
               MetricType::Counter,
               {Sample(MetricType::Counter, static_cast<double>(results.found_in_memory),
                       {{"found", "memory"}}),
                Sample(MetricType::Counter, static_cast<double>(results.found_in_store),
                       {{"found", "disk"}}),
                Sample(MetricType::Counter, static_cast<double>(results.not_found),
                       {{"found", "nowhere"}})}});
  AddGauge(f, "penumbra_result_memory_bytes", "Bytes of final artifacts held in memory",
           static_cast<double>(results.bytes));
  AddGauge(f, "penumbra_result_disk_bytes", "Bytes of final artifacts held on disk",
           static_cast<double>(gauges.stored_result_bytes));
}

void AddGauges(Families& f, const MetricsGauges& gauges) {
  AddGauge(f, "penumbra_scenes", "Scenes", static_cast<double>(gauges.scenes));
  AddGauge(f, "penumbra_jobs_waiting", "Jobs that wait for a thread",
           static_cast<double>(gauges.jobs_waiting));
  AddGauge(f, "penumbra_jobs_running", "Jobs that run", static_cast<double>(gauges.jobs_running));
  AddGauge(f, "penumbra_blobs", "Blobs held", static_cast<double>(gauges.blobs));
  AddGauge(f, "penumbra_blob_bytes", "Bytes of blobs held, uploads under way included",
           static_cast<double>(gauges.blob_bytes));
  AddGauge(f, "penumbra_uptime_seconds", "Time since the start", gauges.uptime_seconds);
  AddGauge(f, "penumbra_read_delay_seconds", "How long requests wait until they are read",
           gauges.read_delay_seconds);
  AddGauge(f, "penumbra_degraded", "1 where there is no OpenGL", gauges.is_degraded ? 1 : 0);
  f.push_back({"penumbra_gl_info",
               "The OpenGL in use",
               MetricType::Gauge,
               {Sample(MetricType::Gauge, 1,
                       {{"vendor", gauges.gl_vendor},
                        {"renderer", gauges.gl_renderer},
                        {"version", gauges.gl_version},
                        {"device", gauges.gl_device}})}});
  f.push_back({"penumbra_build_info",
               "The server",
               MetricType::Gauge,
               {Sample(MetricType::Gauge, 1, {{"server", kServerName}})}});
}

}  // namespace

MetricsCollector::MetricsCollector(const ServerCounters& counters,
                                   std::function<MetricsGauges()> gauges)
    : counters_(counters), gauges_(std::move(gauges)) {}

std::vector<MetricFamily> MetricsCollector::Collect() const {
  const MetricsGauges gauges = gauges_();
  Families families;
  AddServing(families, counters_);
  AddComputing(families, counters_, gauges.engine);
  AddResults(families, gauges);
  AddGauges(families, gauges);
  return families;
}

}  // namespace penumbra
