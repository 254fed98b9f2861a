#include "tests/load/overload_bars.h"

#include <algorithm>
#include <cstdio>

#include "absl/strings/str_cat.h"
#include "tests/load/percentiles.h"

namespace penumbra::load {
namespace {

// The ramp's steps are a quarter: what is carried may be as much more than the maximum it found.
constexpr double kGoodputBar = 0.8, kMostGoodput = 1.3;
constexpr double kLoadBar = 0.95, kRefusalBarMs = 50, kNormalBarS = 5;
constexpr double kNever = 1e9;

}  // namespace

absl::Status Bars::status() const {
  if (missed_.empty()) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat("missed:", missed_));
}

void Bars::Print(const char* name, double value, double bar, bool is_met) {
  std::printf("%s %.3f (bar %.3f) %s\n", name, value, bar, is_met ? "met" : "MISSED");
  if (!is_met) absl::StrAppend(&missed_, " ", name);
}

void Judge(const OverloadFindings& findings, Bars& bars) {
  const Outcome& over = findings.over;
  // Whoever waits because they were told to has the wish all the same; the deaf have sent it.
  const double load_per_s = findings.is_deaf ? over.sent_per_s() : over.due_per_s();
  bars.AtLeast("overload.load_reached", load_per_s / (findings.times * findings.maximum_per_s),
               kLoadBar);
  bars.AtMost("overload.sent_late_p99_ms", over.late_p99_ms, kRefusalBarMs);
  // Without these it was no overload.
  bars.AtLeast("overload.turned_away", static_cast<double>(over.refusal_ms.size() + over.held), 1);
  const double goodput = over.goodput() / findings.maximum_per_s;
  bars.AtMost("overload.goodput_beyond_maximum", goodput, kMostGoodput);

  bars.AtLeast("overload.goodput_of_maximum", goodput, kGoodputBar);
  bars.AtMost("overload.refusal_p99_ms",
              over.refusal_ms.empty() ? kNever : Percentile(over.refusal_ms, 0.99), kRefusalBarMs);
  bars.AtMost("overload.refused_without_delay", static_cast<double>(over.refused_without_delay), 0);
  bars.AtMost("overload.seconds_to_normal", findings.seconds_to_normal.value_or(kNever),
              kNormalBarS);
  bars.AtMost("overload.acknowledged_and_lost", static_cast<double>(findings.lost), 0);
}

size_t LostCommits(const std::map<std::string, size_t>& acknowledged_by_scene,
                   const std::vector<SceneInfo>& scenes) {
  size_t lost = 0;
  for (const auto& [id, acknowledged] : acknowledged_by_scene) {
    const auto scene = std::ranges::find(scenes, id, &SceneInfo::id);
    const size_t kept = scene == scenes.end() || scene->revision == 0 ? 0 : scene->revision - 1;
    lost += acknowledged - std::min(acknowledged, kept);
  }
  return lost;
}

}  // namespace penumbra::load
