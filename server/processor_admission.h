// Which commits are let in where the processor does not keep up with reading them.
//
//   if (auto status = processor.AdmitCommit(principal, session, false); !status.ok()) …
#pragma once

#include <string>

#include "absl/status/status.h"
#include "server/limits.h"
#include "server/read_delay.h"
#include "server/request_shares.h"

namespace penumbra {

// Any thread may use it.
class ProcessorAdmission {
 public:
  // `limits` outlives it.
  explicit ProcessorAdmission(const ServerLimits& limits) : limits_(limits) {}

  // `has_unanswered`  other requests of the session have no answer yet
  // Errors  those of AdmitByReadDelay
  absl::Status AdmitCommit(const std::string& principal, const void* session, bool has_unanswered);

  const ReadDelay& read_delay() const { return read_delay_; }
  RequestShares& shares() { return shares_; }

 private:
  const ServerLimits& limits_;
  ReadDelay read_delay_;
  RequestShares shares_;
};

}  // namespace penumbra
