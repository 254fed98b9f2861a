#include "server/quota/principal_quotas.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"
#include "render/scene/retry_delay.h"

namespace penumbra {
namespace {

constexpr double kSecondsPerMinute = 60;

}  // namespace

const PrincipalQuota& PrincipalQuotas::Of(const std::string& principal) const {
  const auto named = options_.named.find(principal);
  return named == options_.named.end() ? options_.each : named->second;
}

PrincipalQuotas::Account& PrincipalQuotas::AccountOf(const std::string& principal,
                                                     const PrincipalQuota& quota) {
  const auto now = now_();
  const auto [account, is_new] =
      accounts_.try_emplace(principal, Account{quota.compute_s_per_minute, now});
  const std::chrono::duration<double> passed = now - account->second.as_of;
  account->second.in_hand_s = std::min(
      quota.compute_s_per_minute,
      account->second.in_hand_s + passed.count() * quota.compute_s_per_minute / kSecondsPerMinute);
  account->second.as_of = now;
  return account->second;
}

ComputeAccounts::Standing PrincipalQuotas::StandingOf(const std::string& principal) {
  const PrincipalQuota& quota = Of(principal);
  Standing standing{.weight = quota.weight};
  if (quota.compute_s_per_minute <= 0) return standing;
  std::lock_guard lock(mutex_);
  standing.gives_way = AccountOf(principal, quota).in_hand_s <= 0;
  return standing;
}

void PrincipalQuotas::Charge(const std::string& principal, double ms) {
  const PrincipalQuota& quota = Of(principal);
  if (quota.compute_s_per_minute <= 0) return;
  std::lock_guard lock(mutex_);
  AccountOf(principal, quota).in_hand_s -= 1e-3 * ms;
  // Names come and go; whoever has all in hand again needs no account.
  constexpr size_t kManyAccounts = 1'024;
  if (accounts_.size() <= kManyAccounts) return;
  const auto now = now_();
  std::erase_if(accounts_, [&](const auto& row) {
    return now - row.second.as_of > std::chrono::minutes(1) && row.second.in_hand_s >= 0;
  });
}

absl::Status PrincipalQuotas::CheckCompute(const std::string& principal) {
  const PrincipalQuota& quota = Of(principal);
  if (quota.compute_s_per_minute <= 0) return absl::OkStatus();
  std::lock_guard lock(mutex_);
  const double in_hand_s = AccountOf(principal, quota).in_hand_s;
  if (in_hand_s > 0) return absl::OkStatus();
  const double wait_s = -in_hand_s * kSecondsPerMinute / quota.compute_s_per_minute;
  return WithRetryDelay(
      FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_COMPUTE", "compute",
                 absl::StrCat("found ", quota.compute_s_per_minute - in_hand_s,
                              " s of computing, need at most ", quota.compute_s_per_minute,
                              " a minute: what is new waits until nobody else's does")),
      1e3 * wait_s);
}

}  // namespace penumbra
