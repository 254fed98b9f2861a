// How late messages come that are sent one after another, where that lasts: a thread has to wait
// for its turn, or a whole machine stands still, and what has piled up meanwhile is soon read. So
// of what is late it takes two, the second hardly sooner than the first: as much comes as is read.
//
//   DelayTrend trend;
//   trend.OnSent(now);
//   trend.OnCame(now);
//   trend.OnAdmission(is_refused, now);   // for each request
//   if (trend.Now(now) > limit) …
#pragma once

#include <chrono>

namespace penumbra {

class DelayTrend {
 public:
  using Clock = std::chrono::steady_clock;

  // What is older says nothing about now.
  static constexpr std::chrono::milliseconds kMemory{250};
  // A message that takes longer is late. One may be by chance, but none by so much as the second.
  static constexpr std::chrono::milliseconds kLate{6}, kVeryLate{12};
  // One that is under way for so long counts alone.
  static constexpr std::chrono::milliseconds kAlone{250};
  // For so long after two late ones all count, and for so long again after two within that, or one
  // that is very late.
  static constexpr std::chrono::seconds kAlert{1};
  // At its end, if there was a late one lately, it begins anew where this part of the requests was
  // refused: then few are late because many were sent away, who come back.
  static constexpr double kManyRefused = 0.03;
  static constexpr std::chrono::seconds kLately{5};

  void OnSent(Clock::time_point now);  // the last one has come
  void OnCame(Clock::time_point now);  // the one under way
  // The one under way does not come any more.
  void OnLost() { is_under_way_ = false; }
  // A request was refused or not.
  void OnAdmission(bool is_refused, Clock::time_point now);

  // What the last one took, or the one under way is taking; none: that says nothing.
  Clock::duration Now(Clock::time_point now) const;

  bool is_under_way() const { return is_under_way_; }
  Clock::time_point sent() const { return sent_; }

 private:
  Clock::duration Last(Clock::time_point now) const;

  bool is_under_way_ = false;
  Clock::time_point sent_{}, came_{}, late_{}, alert_until_{};
  Clock::duration last_{};             // what the last one has taken; none: too long ago
  double requests_ = 0, refused_ = 0;  // in this alert
};

}  // namespace penumbra
