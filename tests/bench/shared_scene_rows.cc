// Many clients on one scene: what each of them costs, and what those cost the others who never
// read. Parts of ServiceSuite.
//
// penumbrad runs as a process of its own; 84 boxes over a floor (256 × 256 texels, 64 samples)
// under a lamp that is dragged. The clients are sessions of this process, each on a connection of
// its own: they read and acknowledge, and do not decode.

#include <algorithm>
#include <chrono>
#include <future>
#include <thread>
#include <vector>

#include "tests/bench/bench.h"
#include "tests/bench/studio.h"
#include "tests/load/shared_scene.h"

namespace penumbra::bench {
namespace {

using load::SharedScene;
using load::Watcher;
using Watchers = std::vector<std::unique_ptr<Watcher>>;

constexpr int kBoxes = 84;
constexpr uint32_t kTexels = 256;
constexpr double kLampRate = 30;
constexpr double kLampSeconds = 20;
constexpr int kLampClients = 64;

// Different revisions whose artifacts came.
size_t RevisionsIn(const std::vector<load::Arrival>& arrivals) {
  size_t count = 0;
  Revision last = 0;
  for (const load::Arrival& arrival : arrivals) {
    if (arrival.is_new && arrival.revision > last) ++count;
    last = std::max(last, arrival.revision);
  }
  return count;
}

struct Drag {
  size_t edits = 0;
  double seconds = 0;
  double cpu_seconds = 0;       // of the server
  double least_per_second = 0;  // of the client that got least
  double bytes_per_update = 0;
  v1::ServerStatistics before, after;
};

Drag WatchTheLamp(SharedScene& scene, int clients) {
  Watchers watchers = OrDie(load::OpenWatchers(scene, clients));
  Drag drag{.before = OrDie(scene.Statistics())};
  for (const auto& watcher : watchers) watcher->TakeArrivals();
  const double cpu = scene.usage().cpu_seconds;
  uint64_t bytes = 0, updates = 0;
  for (const auto& watcher : watchers) bytes -= watcher->received_bytes();
  const load::LampDrag lamp = OrDie(scene.DragLamp(kLampRate, kLampSeconds));
  drag.edits = lamp.edits.size();
  drag.seconds = lamp.seconds;
  drag.cpu_seconds = scene.usage().cpu_seconds - cpu;
  drag.least_per_second = kLampRate;
  for (const auto& watcher : watchers) {
    const size_t revisions = RevisionsIn(watcher->TakeArrivals());
    drag.least_per_second =
        std::min(drag.least_per_second, static_cast<double>(revisions) / drag.seconds);
    updates += revisions;
    bytes += watcher->received_bytes();
  }
  drag.bytes_per_update =
      static_cast<double>(bytes) / static_cast<double>(std::max<uint64_t>(updates, 1));
  drag.after = OrDie(scene.Statistics());
  return drag;
}

std::vector<Row> LampRows(SharedScene& scene) {
  const Drag alone = WatchTheLamp(scene, 1);
  const Drag all = WatchTheLamp(scene, kLampClients);
  const auto of_all = [&](auto member) {
    return static_cast<double>((all.after.*member)() - (all.before.*member)());
  };
  const double jobs = of_all(&v1::ServerStatistics::jobs_started);
  const std::string prefix = "service.lamp.";
  return {{prefix + "updates_per_second_least", all.least_per_second, "1/s"},
          {prefix + "jobs_per_edit", jobs / static_cast<double>(all.edits), "ratio"},
          {prefix + "encoded_per_job", of_all(&v1::ServerStatistics::artifacts_encoded) / jobs,
           "ratio"},
          {prefix + "bytes_per_update", all.bytes_per_update, "bytes"},
          {prefix + "cpu_alone", 1e3 * alone.cpu_seconds / alone.seconds, "ms/s"},
          {prefix + "cpu_per_further_client",
           1e3 * (all.cpu_seconds / all.seconds - alone.cpu_seconds / alone.seconds) /
               (kLampClients - 1),
           "ms/s"}};
}

constexpr int kReaders = 24;
constexpr int kSilent = 8;  // a quarter of all
constexpr double kEditRate = 10;
constexpr double kPhaseSeconds = 10;
constexpr int kPhases = 2;  // with and without, in turn

double MiB(uint64_t bytes) { return static_cast<double>(bytes) / (1 << 20); }

struct Growth {
  double most_mib = 0;        // over what it was before
  double mib_per_minute = 0;  // over the second half

  void Include(const Growth& other) {
    most_mib = std::max(most_mib, other.most_mib);
    mib_per_minute = std::max(mib_per_minute, other.mib_per_minute);
  }
};

// Of the server, while `work` runs.
template <typename Work>
Growth GrowthDuring(const SharedScene& scene, Work work) {
  const uint64_t before = scene.usage().resident_bytes;
  auto done = std::async(std::launch::async, work);
  std::vector<double> mib;
  do {
    mib.push_back(MiB(scene.usage().resident_bytes) - MiB(before));
  } while (done.wait_for(std::chrono::milliseconds(250)) != std::future_status::ready);
  const size_t middle = mib.size() / 2;
  const double minutes = 0.25 * static_cast<double>(mib.size() - middle) / 60;
  return {.most_mib = *std::max_element(mib.begin(), mib.end()),
          .mib_per_minute = (mib.back() - mib[middle]) / minutes};
}

std::vector<Row> SilentReaderRows(SharedScene& scene) {
  Watchers readers = OrDie(load::OpenWatchers(scene, kReaders));
  std::vector<double> without_ms, with_ms;
  Growth most, most_without;
  const auto drag = [&](std::vector<double>& latencies_ms) {
    for (const auto& reader : readers) reader->TakeArrivals();
    const load::LampDrag lamp = OrDie(scene.DragLamp(kEditRate, kPhaseSeconds));
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(2);
    for (const auto& reader : readers) {
      reader->AwaitRevision(lamp.edits.back().revision, deadline);
      const auto some = load::LatenciesMs(lamp.edits, reader->TakeArrivals(), deadline);
      latencies_ms.insert(latencies_ms.end(), some.begin(), some.end());
    }
  };
  for (int i = 0; i < kPhases; ++i) {
    most_without.Include(GrowthDuring(scene, [&] { drag(without_ms); }));
    Watchers silent;
    most.Include(GrowthDuring(scene, [&] {
      silent = OrDie(load::OpenWatchers(scene, kSilent, {.reads = false}));
      drag(with_ms);
    }));
  }
  const double with_p99 = Percentile(with_ms, 0.99), without_p99 = Percentile(without_ms, 0.99);
  const std::string prefix = "service.silent_readers.";
  return {{prefix + "memory_growth", most.most_mib, "MiB"},
          {prefix + "memory_slope", most.mib_per_minute, "MiB/min"},
          {prefix + "memory_growth_without", most_without.most_mib, "MiB"},
          {prefix + "memory_slope_without", most_without.mib_per_minute, "MiB/min"},
          {prefix + "others_p99", with_p99, "ms"},
          {prefix + "others_p99_without", without_p99, "ms"},
          {prefix + "others_p99_ratio", with_p99 / without_p99, "ratio"}};
}

}  // namespace

std::vector<Row> SharedSceneRows() {
  const auto scene = OrDie(SharedScene::Start(Boxes(kBoxes, kTexels)));
  std::vector<Row> rows = LampRows(*scene);
  for (Row& row : SilentReaderRows(*scene)) rows.push_back(std::move(row));
  return rows;
}

}  // namespace penumbra::bench
