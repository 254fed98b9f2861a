// What each principal may use of a server, and what it has computed.
//
//   PrincipalQuotas quotas({.each = {.scenes = 20, .compute_s_per_minute = 30}});
//   scenes.Create("studio", {"ana", quotas.Of("ana").scenes});
//   if (auto status = quotas.CheckCompute("ana"); !status.ok()) …told, not refused
//
// A second of compute is a second of a job on one of the runners, whatever threads it has of those
// that jobs share. A principal has as many in hand as its quota says for a minute, and gets them
// back at that rate. While it has none its jobs run only where nobody else's wait: it keeps what it
// has, and what is new comes late.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "render/engine/compute_accounts.h"

namespace penumbra {

// Of each 0 is no quota.
struct PrincipalQuota {
  uint32_t scenes = 0;    // that it has made
  uint32_t sessions = 0;  // open at a time
  uint64_t blob_bytes = 0;
  double compute_s_per_minute = 0;
  double weight = 1;  // of its jobs, against those of others in the same scene; > 0
};

struct QuotaOptions {
  PrincipalQuota each{};
  std::map<std::string, PrincipalQuota> named{};  // instead, of these
};

// Any thread may use it.
class PrincipalQuotas : public ComputeAccounts {
 public:
  using Clock = std::function<std::chrono::steady_clock::time_point()>;

  explicit PrincipalQuotas(QuotaOptions options, Clock now = std::chrono::steady_clock::now)
      : options_(std::move(options)), now_(std::move(now)) {}

  const PrincipalQuota& Of(const std::string& principal) const;

  Standing StandingOf(const std::string& principal) override;
  void Charge(const std::string& principal, double ms) override;

  // Errors  kResourceExhausted QUOTA_COMPUTE, with a retry delay: it has none in hand
  absl::Status CheckCompute(const std::string& principal);

 private:
  struct Account {
    double in_hand_s = 0;  // less than 0: of jobs that took longer than there was
    std::chrono::steady_clock::time_point as_of{};
  };
  // Up to date; with the lock held. `quota` has a quota of compute.
  Account& AccountOf(const std::string& principal, const PrincipalQuota& quota);

  const QuotaOptions options_;
  const Clock now_;
  std::mutex mutex_;
  std::map<std::string, Account> accounts_;  // of those who have less than all in hand
};

}  // namespace penumbra
