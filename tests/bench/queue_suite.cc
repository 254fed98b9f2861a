// What it costs to find out whose turn it is: a job added to the queue, taken, and accounted for,
// with others that wait. The peer is a line in which the one that people look at most goes first,
// looked through from end to end.

#include <algorithm>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "render/engine/fair_share.h"
#include "tests/bench/bench.h"

namespace penumbra::bench {
namespace {

class IdleJob : public QueuedJob {
 public:
  explicit IdleJob(double share) : share_(share) {}
  double viewed_share() const override { return share_; }
  double Run() override { return 0; }

 private:
  const double share_;
};

struct Case {
  std::string name;
  size_t scenes, viewers, jobs;  // of each scene; of each scene, of whom all want each of its jobs
};

// Turns of a queue in which always as many jobs wait.
class Turns {
 public:
  explicit Turns(const Case& what) : entries_(what.scenes * what.jobs), paths_(what.scenes) {
    for (size_t s = 0; s < what.scenes; ++s) {
      for (size_t v = 0; v < what.viewers; ++v) {
        names_.push_back("scene" + std::to_string(s));
        names_.push_back("viewer" + std::to_string(100 + v));
        const std::string& viewer = names_.back();
        paths_[s].push_back({{{names_[names_.size() - 2]}, {"ana"}, {viewer}}});
      }
    }
    for (size_t i = 0; i < entries_.size(); ++i) {
      auto job = std::make_shared<IdleJob>(static_cast<double>(i % 7));
      line_.push_back(job);
      entries_[i] = {.job = std::move(job), .estimate = 1.0 + static_cast<double>(i % 5)};
      Add(i);
    }
  }

  void TakeFair(int count) {
    for (int i = 0; i < count; ++i) {
      FairShare::Entry* const entry = share_.Take();
      share_.End(*entry, entry->estimate);
      Add(static_cast<size_t>(entry - entries_.data()));
    }
  }
  void TakeFromLine(int count) {
    for (int i = 0; i < count; ++i) {
      const auto first = std::max_element(
          line_.begin(), line_.end(),
          [](const auto& a, const auto& b) { return a->viewed_share() < b->viewed_share(); });
      auto job = std::move(*first);
      line_.erase(first);
      line_.push_back(std::move(job));
    }
  }

 private:
  void Add(size_t index) {
    entries_[index].arrival = ++arrivals_;
    share_.Add(entries_[index], paths_[index % paths_.size()]);
  }

  std::deque<std::string> names_;
  std::vector<FairShare::Entry> entries_;
  std::vector<std::vector<FairShare::Path>> paths_;
  std::vector<std::shared_ptr<QueuedJob>> line_;
  FairShare share_;
  uint64_t arrivals_ = 0;
};

}  // namespace

std::vector<Row> QueueSuite(const BenchOptions& options) {
  const Case cases[] = {{"one_scene_10_jobs", 1, 1, 10},
                        {"50_scenes_20_jobs", 50, 1, 20},
                        {"64_viewers_100_jobs", 1, 64, 100},
                        {"one_scene_1000_jobs", 1, 1, 1'000}};
  constexpr int kTurns = 2'000;
  constexpr double kNsPerMs = 1e6;
  std::vector<Row> rows;
  for (const Case& what : cases) {
    Turns turns(what);
    const Duel duel = Interleave(
        options.min_seconds, [&] { turns.TakeFair(kTurns); }, [&] { turns.TakeFromLine(kTurns); });
    const std::string prefix = "queue." + what.name;
    rows.push_back({prefix + ".turn", duel.OursMs() * kNsPerMs / kTurns, "ns"});
    rows.push_back({prefix + ".line", duel.PeersMs() * kNsPerMs / kTurns, "ns"});
    rows.push_back({prefix + ".overhead_vs_line", 1 / duel.Speedup(), ""});
  }
  return rows;
}

}  // namespace penumbra::bench
