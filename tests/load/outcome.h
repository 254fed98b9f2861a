// What was due in some time of an overload, and what became of it.
//
//   Outcome outcome = Summarize(records, seconds, late_p99_ms);
//   double maximum = FindMaximum([&](double rate) { return drive(rate, 4.0); });
#pragma once

#include <functional>
#include <vector>

#include "tests/load/open_client.h"

namespace penumbra::load {

struct Outcome {
  double seconds = 0;                         // as measured: to when the last one was sent
  std::vector<double> answer_ms, refusal_ms;  // since each was due
  size_t due = 0, held = 0, unanswered = 0, refused_without_delay = 0;
  double late_p99_ms = 0;  // how late this program was itself

  double due_per_s() const { return static_cast<double>(due) / seconds; }
  double sent_per_s() const { return static_cast<double>(due - held) / seconds; }
  double goodput() const { return static_cast<double>(answer_ms.size()) / seconds; }
};

void Add(const CommitRecord& record, Outcome& outcome);
Outcome Summarize(const std::vector<CommitRecord>& records, double seconds, double late_p99_ms);

// A load counts as carried when 99 % of it was acknowledged, and the slowest hundredth of that
// within 100 ms.
bool IsCarried(const Outcome& outcome);

// So often a rate is tried: something else may run on the machine meanwhile.
inline constexpr int kTries = 3;
// The greatest goodput of the rates, each a quarter more than the one before, that were carried by
// one of the tries; 0: not even the first. `drive` sends at a rate, in commits a second.
double FindMaximum(const std::function<Outcome(double rate)>& drive);

void Print(const char* name, const Outcome& outcome);

}  // namespace penumbra::load
