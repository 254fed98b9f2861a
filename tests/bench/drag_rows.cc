// Dragging a lamp through the server: how many updates come in time, and how soon after the last
// edit the shadow is whole again.
//
// Server and client run in this process and talk over loopback TCP. For ten seconds a lamp moves 30
// times a second over 1,000 boxes; the artifact (512 × 512 texels, 1,024 samples) takes far longer
// than the 33 ms between edits, so that first passes have to make do with fewer samples. An edit is
// on time if, within 33 ms of committing it, an artifact of its revision or a later one is here.

#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <thread>
#include <vector>

#include "client/session/remote_engine.h"
#include "server/penumbra_server.h"
#include "tests/bench/bench.h"
#include "tests/bench/studio.h"

namespace penumbra::bench {
namespace {

constexpr int kEditsPerSecond = 30;
constexpr double kSeconds = 10;
constexpr double kTargetMs = 33;
constexpr uint32_t kTexels = 512;
constexpr uint32_t kSamples = 1024;

struct Arrival {
  Revision revision;
  double time_ms;
  uint32_t samples;
  bool is_final;
};

// What came, in order.
class Log {
 public:
  void Put(const ArtifactUpdate& update) {
    if (!update.artifact) return;
    const ArtifactHeader& header = update.artifact->header;
    {
      std::lock_guard lock(mutex_);
      arrivals_.push_back({update.revision, NowMs(),
                           static_cast<uint32_t>(header.light_samples.size()), header.is_final});
    }
    came_.notify_all();
  }
  // Waits for the final artifact of `revision`.
  std::vector<Arrival> AwaitFinal(Revision revision) {
    std::unique_lock lock(mutex_);
    came_.wait(lock, [&] {
      return !arrivals_.empty() && arrivals_.back().is_final &&
             arrivals_.back().revision >= revision;
    });
    return arrivals_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable came_;
  std::vector<Arrival> arrivals_;
};

struct Edit {
  Revision revision;
  double time_ms;
};

AreaLight LampAt(double seconds) {
  const auto x = static_cast<float>(2 * std::sin(seconds)),
             z = static_cast<float>(std::cos(seconds));
  return {.id = "lamp",
          .shape = RectangleLight{
              .corner = Vec3(x - 1, 8, z - 1), .edge_u = Vec3(2, 0, 0), .edge_v = Vec3(0, 0, 2)}};
}

std::vector<Edit> Drag(RemoteEngine& engine) {
  std::vector<Edit> edits;
  const auto start = std::chrono::steady_clock::now();
  for (int i = 1; i <= kSeconds * kEditsPerSecond; ++i) {
    std::this_thread::sleep_until(start +
                                  std::chrono::microseconds(i * 1'000'000 / kEditsPerSecond));
    const double time_ms = NowMs();
    edits.push_back({OrDie(engine.Commit(
                         "studio", {.upsert_lights = {LampAt(double{1} * i / kEditsPerSecond)}})),
                     time_ms});
  }
  return edits;
}

// How long after its commit each edit was first seen.
std::vector<double> Latencies(const std::vector<Edit>& edits,
                              const std::vector<Arrival>& arrivals) {
  std::vector<double> latencies_ms;
  for (const Edit& edit : edits) {
    for (const Arrival& arrival : arrivals) {
      if (arrival.revision < edit.revision) continue;
      latencies_ms.push_back(arrival.time_ms - edit.time_ms);
      break;
    }
  }
  return latencies_ms;
}

}  // namespace

std::vector<Row> DragRows(const BenchOptions& options) {
  const auto server = OrDie(PenumbraServer::Start(
      {.listen = "127.0.0.1:0", .threads = options.threads, .opens_gl = false}));
  const auto engine = OrDie(RemoteEngine::Connect({.address = server->address()}));
  if (!engine->CreateScene("studio").ok()) std::exit(EXIT_FAILURE);
  const Revision first = OrDie(engine->Commit("studio", Boxes(1000, kTexels)));
  Log log;
  const ArtifactSpec spec{.params = SoftTextureParams{.samples = kSamples},
                          .light_id = "lamp",
                          .receiver_id = "floor",
                          .time_budget_ms = kTargetMs};
  const auto subscription = OrDie(
      engine->Subscribe("studio", spec, [&](const ArtifactUpdate& update) { log.Put(update); }));
  log.AwaitFinal(first);
  const std::vector<Edit> edits = Drag(*engine);
  const std::vector<Arrival> arrivals = log.AwaitFinal(edits.back().revision);
  const std::vector<double> latencies_ms = Latencies(edits, arrivals);
  double on_time = 0;
  for (const double latency : latencies_ms) on_time += latency <= kTargetMs;
  std::vector<double> samples;
  for (const Arrival& arrival : arrivals) {
    if (arrival.revision > first && !arrival.is_final) samples.push_back(arrival.samples);
  }
  const std::string prefix = "soft_texture.drag.";
  return {{prefix + "on_time_fraction", on_time / static_cast<double>(edits.size()), "1"},
          {prefix + "latency_median", Median(latencies_ms), "ms"},
          {prefix + "latency_p95", Percentile(latencies_ms, 0.95), "ms"},
          {prefix + "samples_median", Median(samples), "1"},
          {prefix + "whole_after_last_edit", arrivals.back().time_ms - edits.back().time_ms, "ms"}};
}

}  // namespace penumbra::bench
