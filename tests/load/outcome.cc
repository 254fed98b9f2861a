#include "tests/load/outcome.h"

#include <cstdio>

#include "absl/strings/str_cat.h"
#include "tests/load/percentiles.h"

namespace penumbra::load {
namespace {

using Fate = CommitRecord::Fate;

constexpr double kCarriedFraction = 0.99;
constexpr double kCarriedP99Ms = 100;
constexpr double kFirstRate = 250, kStep = 1.25, kMostRate = 64'000;

}  // namespace

void Add(const CommitRecord& record, Outcome& outcome) {
  ++outcome.due;
  const double ms = std::chrono::duration<double, std::milli>(record.answered - record.due).count();
  if (record.fate == Fate::kAccepted) outcome.answer_ms.push_back(ms);
  if (record.fate == Fate::kRefused) outcome.refusal_ms.push_back(ms);
  outcome.refused_without_delay += record.fate == Fate::kRefused && !record.is_told_to_wait;
  outcome.held += record.fate == Fate::kHeld;
  outcome.unanswered += record.fate == Fate::kUnanswered;
}

Outcome Summarize(const std::vector<CommitRecord>& records, double seconds, double late_p99_ms) {
  Outcome outcome{.seconds = seconds, .late_p99_ms = late_p99_ms};
  for (const CommitRecord& record : records) Add(record, outcome);
  return outcome;
}

bool IsCarried(const Outcome& outcome) {
  return !outcome.answer_ms.empty() &&
         static_cast<double>(outcome.answer_ms.size()) >=
             kCarriedFraction * static_cast<double>(outcome.due) &&
         Percentile(outcome.answer_ms, 0.99) <= kCarriedP99Ms;
}

double FindMaximum(const std::function<Outcome(double rate)>& drive) {
  double maximum = 0;
  for (double rate = kFirstRate; rate < kMostRate; rate *= kStep) {
    bool is_carried = false;
    for (int i = 0; i < kTries && !is_carried; ++i) {
      const Outcome outcome = drive(rate);
      const double p99_ms = outcome.answer_ms.empty() ? 0 : Percentile(outcome.answer_ms, 0.99);
      std::printf("ramp %.0f/s: %.0f/s acknowledged, p99 %.1f ms, %zu refused, late %.1f ms\n",
                  rate, outcome.goodput(), p99_ms, outcome.refusal_ms.size(), outcome.late_p99_ms);
      std::fflush(stdout);
      is_carried = IsCarried(outcome);
      if (is_carried) maximum = outcome.goodput();
    }
    if (!is_carried) break;
  }
  return maximum;
}

void Print(const char* name, const Outcome& outcome) {
  std::printf("%s.seconds %.2f\n%s.due_per_s %.0f\n%s.sent_per_s %.0f\n%s.goodput_per_s %.0f\n",
              name, outcome.seconds, name, outcome.due_per_s(), name, outcome.sent_per_s(), name,
              outcome.goodput());
  std::printf("%s.refused %zu\n%s.held_back %zu\n%s.unanswered %zu\n%s.sent_late_p99_ms %.1f\n",
              name, outcome.refusal_ms.size(), name, outcome.held, name, outcome.unanswered, name,
              outcome.late_p99_ms);
  PrintPercentiles(absl::StrCat(name, ".answer").c_str(), outcome.answer_ms);
  PrintPercentiles(absl::StrCat(name, ".refusal").c_str(), outcome.refusal_ms);
  std::fflush(stdout);
}

}  // namespace penumbra::load
