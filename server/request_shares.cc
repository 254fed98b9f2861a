#include "server/request_shares.h"

#include <algorithm>
#include <cmath>

namespace penumbra {
namespace {

constexpr std::chrono::seconds kHalfLife{1};
// Whoever has not sent for a few seconds is no sender.
constexpr double kNothing = 0.25;
constexpr int kAllGone = 32;

}  // namespace

template <typename Sender>
double RequestShares::Counts<Sender>::Add(const Sender& sender) {
  const double theirs = ++of_[sender];
  ++all_;
  return theirs * static_cast<double>(of_.size()) / all_;
}

template <typename Sender>
void RequestShares::Counts<Sender>::Halve(int times) {
  all_ = 0;
  for (auto at = of_.begin(); at != of_.end();) {
    at->second = std::ldexp(at->second, -times);
    if (at->second < kNothing) {
      at = of_.erase(at);
    } else {
      all_ += (at++)->second;
    }
  }
}

RequestShare RequestShares::OnRequest(const std::string& principal, const void* session,
                                      Clock::time_point now) {
  std::lock_guard lock(mutex_);
  if (const auto times = (now - halved_) / kHalfLife; times > 0) {
    const int most = static_cast<int>(std::min<decltype(times)>(times, kAllGone));
    principals_.Halve(most);
    sessions_.Halve(most);
    halved_ = times > kAllGone ? now : halved_ + times * kHalfLife;
  }
  const double of_mean = std::min(principals_.Add(principal), sessions_.Add(session));
  return {.of_mean = of_mean, .sessions = sessions_.senders()};
}

}  // namespace penumbra
