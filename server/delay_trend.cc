#include "server/delay_trend.h"

#include <algorithm>

namespace penumbra {
namespace {

using Duration = DelayTrend::Clock::duration;

constexpr Duration kNone = Duration::zero();
// After a pause each message takes as much of what the one before took as comes of what can be
// read: at nine tenths it is no pause that one waits for.
constexpr double kFalling = 0.9;

// Whether what waits does not become less.
bool Lasts(Duration before, Duration after) {
  return before >= DelayTrend::kLate && after >= kFalling * before;
}

}  // namespace

void DelayTrend::OnSent(Clock::time_point now) {
  last_ = Last(now);
  is_under_way_ = true;
  sent_ = now;
}

void DelayTrend::OnCame(Clock::time_point now) {
  const Duration before = last_;
  is_under_way_ = false;
  came_ = now;
  last_ = now - sent_;
  if (last_ >= kLate) late_ = now;
  const bool is_on_alert = now < alert_until_;
  const bool is_late_again = std::min(before, last_) >= kLate || last_ >= kVeryLate;
  if (Lasts(before, last_) || (is_on_alert && is_late_again)) alert_until_ = now + kAlert;
}

void DelayTrend::OnAdmission(bool is_refused, Clock::time_point now) {
  if (now >= alert_until_) {
    const bool was_on_alert = now < alert_until_ + kMemory;
    const bool are_many = refused_ > kManyRefused * requests_ && now - late_ < kLately;
    alert_until_ = was_on_alert && are_many ? now + kAlert : Clock::time_point();
    requests_ = refused_ = 0;
  }
  ++requests_;
  refused_ += is_refused;
}

Duration DelayTrend::Now(Clock::time_point now) const {
  const Duration so_far = is_under_way_ ? now - sent_ : kNone;
  if (now >= alert_until_ && so_far < kAlone && !Lasts(last_, so_far)) return kNone;
  return std::max(so_far, Last(now));
}

Duration DelayTrend::Last(Clock::time_point now) const {
  return now - came_ < kMemory ? last_ : kNone;
}

}  // namespace penumbra
