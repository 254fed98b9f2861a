#include "tests/load/overload.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "client/session/remote_engine.h"
#include "tests/load/load_scenes.h"
#include "tests/load/open_client.h"
#include "tests/load/outcome.h"
#include "tests/load/overload_bars.h"
#include "tests/load/percentiles.h"

namespace penumbra::load {
namespace {

using Ms = std::chrono::duration<double, std::milli>;
using Clients = std::vector<std::unique_ptr<OpenClient>>;

constexpr std::chrono::seconds kRampStep{4}, kRest{2}, kAfter{10};
constexpr std::chrono::milliseconds kWindow{500};

class Overload {
 public:
  explicit Overload(const OverloadPlan& plan) : plan_(plan) {}

  absl::Status Begin() {
    if (auto made = MakeScenes(plan_.server, plan_.scenes); !made.ok()) return made.status();
    for (int i = 0; i < plan_.clients; ++i) {
      clients_.push_back(std::make_unique<OpenClient>(plan_.server, SceneId(i % plan_.scenes),
                                                      BoxOf(i), plan_.is_deaf));
      if (auto status = clients_.back()->Open(); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  // One client after another, spread evenly over the time. The answers are waited for until
  // `patience` is over.
  std::vector<CommitRecord> Drive(double rate, double seconds, std::chrono::milliseconds patience) {
    const auto interval =
        std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.0 / rate));
    const auto count = static_cast<int64_t>(rate * seconds);
    const auto start = Clock::now() + std::chrono::milliseconds(50);
    std::vector<double> late_ms;
    for (int64_t i = 0; i < count; ++i) {
      const auto due = start + i * interval;
      std::this_thread::sleep_until(due);
      clients_[static_cast<size_t>(i) % clients_.size()]->Commit(due);
      late_ms.push_back(Ms(Clock::now() - due).count());
    }
    const auto end = std::max(Clock::now(), start + count * interval);
    seconds_ = std::chrono::duration<double>(end - start).count();
    late_p99_ms_ = Percentile(late_ms, 0.99);
    const auto deadline = Clock::now() + patience;
    std::vector<CommitRecord> records;
    for (const auto& client : clients_) client->AwaitAnswers(deadline);
    for (const auto& client : clients_) {
      const auto some = client->TakeRecords();
      records.insert(records.end(), some.begin(), some.end());
      for (const CommitRecord& record : some) {
        accepted_[client->scene_id()] += record.fate == CommitRecord::Fate::kAccepted;
      }
    }
    return records;
  }

  // Of what was driven last.
  Outcome Summary(const std::vector<CommitRecord>& records) const {
    return Summarize(records, seconds_, late_p99_ms_);
  }

  const std::map<std::string, size_t>& accepted_by_scene() const { return accepted_; }

  absl::Status Ended() const {
    for (const auto& client : clients_) {
      if (!client->status().ok()) return client->status();
    }
    return absl::OkStatus();
  }

 private:
  const OverloadPlan plan_;
  Clients clients_;
  double seconds_ = 0;  // that the last drive took
  double late_p99_ms_ = 0;
  std::map<std::string, size_t> accepted_;
};

// From the beginning until all that is due is acknowledged within `usual_ms`; none: never.
std::optional<double> SecondsToNormal(const std::vector<CommitRecord>& records, double usual_ms) {
  if (records.empty()) return std::nullopt;
  const auto by_due = [](const auto& a, const auto& b) { return a.due < b.due; };
  const auto start = std::min_element(records.begin(), records.end(), by_due)->due;
  std::map<int64_t, Outcome> windows;
  for (const CommitRecord& record : records) Add(record, windows[(record.due - start) / kWindow]);
  int64_t last_bad = -1;
  for (const auto& [number, window] : windows) {
    const bool is_good =
        window.answer_ms.size() == window.due && Percentile(window.answer_ms, 0.99) <= usual_ms;
    if (!is_good) last_bad = number;
  }
  if (last_bad == windows.rbegin()->first) return std::nullopt;
  return std::chrono::duration<double>(kWindow).count() * static_cast<double>(last_bad + 1);
}

// The most that the process has had in memory, MiB; 0: nobody knows.
double PeakMemoryMb(int pid) {
  std::ifstream status(absl::StrCat("/proc/", pid, "/status"));
  std::string line;
  while (pid > 0 && std::getline(status, line)) {
    double kilobytes = 0;
    if (!absl::StartsWith(line, "VmHWM:")) continue;
    const std::string number = line.substr(6, line.find("kB") - 6);
    if (absl::SimpleAtod(number, &kilobytes)) return kilobytes / 1024;
  }
  return 0;
}

}  // namespace

absl::Status RunOverload(const OverloadPlan& plan) {
  Overload overload(plan);
  if (auto status = overload.Begin(); !status.ok()) return status;
  const double step_s = std::chrono::duration<double>(kRampStep).count();
  const double maximum = FindMaximum([&](double rate) {
    return overload.Summary(overload.Drive(rate, step_s, std::chrono::seconds(2)));
  });
  if (maximum <= 0) return absl::FailedPreconditionError("not even the first load was carried");
  std::this_thread::sleep_for(kRest);
  std::printf("maximum_per_s %.0f\n", maximum);
  const double half = maximum / 2, after_s = std::chrono::duration<double>(kAfter).count();
  const Outcome before = overload.Summary(overload.Drive(half, after_s, std::chrono::seconds(2)));
  Print("before", before);

  OverloadFindings found{.maximum_per_s = maximum, .times = plan.times, .is_deaf = plan.is_deaf};
  found.over = overload.Summary(
      overload.Drive(plan.times * maximum, plan.seconds, std::chrono::milliseconds(0)));
  const auto records_after = overload.Drive(half, after_s, std::chrono::seconds(5));
  Print("over", found.over);
  Print("after", overload.Summary(records_after));

  // What is usual is noisy: three times the slowest hundredth of before, and no less than a frame.
  const double usual_ms = std::max(3 * Percentile(before.answer_ms, 0.99), 33.0);
  found.seconds_to_normal = SecondsToNormal(records_after, usual_ms);
  if (auto status = overload.Ended(); !status.ok()) return status;
  const auto engine = RemoteEngine::Connect({.address = plan.server});
  if (!engine.ok()) return engine.status();
  const auto scenes = (*engine)->ListScenes();
  if (!scenes.ok()) return scenes.status();
  found.lost = LostCommits(overload.accepted_by_scene(), *scenes);
  Bars bars;
  Judge(found, bars);
  if (plan.server_pid > 0) {
    bars.AtMost("overload.peak_memory_mb", PeakMemoryMb(plan.server_pid), plan.max_memory_mb);
  }
  return bars.status();
}

}  // namespace penumbra::load
