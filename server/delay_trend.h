// How late messages come that are sent one after another, where that is more than a moment: a
// thread has to wait for its turn, or a whole machine stands still, and what has piled up meanwhile
// is soon read. So of what is late it takes two, the second no sooner than the first: more comes
// than is read.
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

  // What is older says nothing about now; and one message alone counts when it has taken so long.
  static constexpr std::chrono::milliseconds kMemory{250};
  // A message that takes longer is late.
  static constexpr std::chrono::milliseconds kLate{6}, kVeryLate{12};
  // For so long after two late ones, the second no sooner, all count. Within that, for so long
  // again after two late ones, one that is very late, or when so many of so many requests were
  // refused for what it says: they come back.
  static constexpr std::chrono::seconds kAlert{1};
  static constexpr int kManyRefused = 6, kRequests = 200;

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
  Clock::time_point sent_{}, came_{}, alert_until_{};
  Clock::duration last_{};  // what the last one has taken
  int requests_ = 0, refused_ = 0;
};

}  // namespace penumbra
