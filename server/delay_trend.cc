#include "server/delay_trend.h"

#include <algorithm>

namespace penumbra {
namespace {

constexpr DelayTrend::Clock::duration kNone = DelayTrend::Clock::duration::zero();

// Whether what waits does not become less.
bool Lasts(DelayTrend::Clock::duration before, DelayTrend::Clock::duration after) {
  return before >= DelayTrend::kLate && after >= before;
}

}  // namespace

void DelayTrend::OnSent(Clock::time_point now) {
  last_ = Last(now);
  is_under_way_ = true;
  sent_ = now;
}

void DelayTrend::OnCame(Clock::time_point now) {
  const Clock::duration before = last_;
  is_under_way_ = false;
  came_ = now;
  last_ = now - sent_;
  const bool is_on_alert = now < alert_until_;
  const bool is_late_again = std::min(before, last_) >= kLate || last_ >= kVeryLate;
  if (Lasts(before, last_) || (is_on_alert && is_late_again)) alert_until_ = now + kAlert;
}

void DelayTrend::OnAdmission(bool is_refused, Clock::time_point now) {
  if (now >= alert_until_) return;
  ++requests_;
  refused_ += is_refused;
  if (requests_ < kRequests) return;
  if (refused_ >= kManyRefused) alert_until_ = now + kAlert;
  requests_ = refused_ = 0;
}

DelayTrend::Clock::duration DelayTrend::Now(Clock::time_point now) const {
  const Clock::duration so_far = is_under_way_ ? now - sent_ : kNone;
  const Clock::duration last = Last(now);
  if (now >= alert_until_ && so_far < kMemory && !Lasts(last, so_far)) return kNone;
  return std::max(so_far, last);
}

DelayTrend::Clock::duration DelayTrend::Last(Clock::time_point now) const {
  return now - came_ < kMemory ? last_ : kNone;
}

}  // namespace penumbra
