// What Prometheus is told: the counters, and what is asked for at the moment of a scrape.
//
//   auto collector = std::make_shared<MetricsCollector>(counters, [&] { return Gauges(); });
//   endpoint->…                                          // metrics_endpoint.h
//
// Adding a metric: a counter in server/counters.h and a line in metrics_collector.cc, which the
// table in docs/operations.md follows. No label ever carries the name of a scene, a client or a
// user.
#pragma once

#include <prometheus/collectable.h>
#include <prometheus/metric_family.h>

#include <functional>
#include <string>
#include <vector>

#include "render/engine/engine_statistics.h"
#include "render/engine/result_cache.h"
#include "server/counters.h"

namespace penumbra {

// What is not counted but looked at.
struct MetricsGauges {
  EngineStatistics engine;
  ResultStatistics results;
  uint64_t stored_result_bytes = 0;
  uint64_t scenes = 0;
  uint64_t jobs_waiting = 0;
  uint64_t jobs_running = 0;
  uint64_t blobs = 0;
  uint64_t blob_bytes = 0;
  double uptime_seconds = 0;
  double read_delay_seconds = 0;
  bool is_degraded = false;
  // GL strings; empty where there is none.
  std::string gl_vendor;
  std::string gl_renderer;
  std::string gl_version;
  std::string gl_device;
};

class MetricsCollector final : public prometheus::Collectable {
 public:
  // Both outlive it. `gauges` is called for each scrape, on the endpoint's threads.
  MetricsCollector(const ServerCounters& counters, std::function<MetricsGauges()> gauges);

  std::vector<prometheus::MetricFamily> Collect() const override;

 private:
  const ServerCounters& counters_;
  const std::function<MetricsGauges()> gauges_;
};

}  // namespace penumbra
