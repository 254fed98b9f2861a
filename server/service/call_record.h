// Counts and times one call, for the metrics, and tells the log when it is refused.
//
//   CallRecord record(counters, logger, "CreateScene");   // when it comes
//   record.End(status);                                   // when it is answered; the first counts
//
// A call that goes without End was cancelled.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "server/counters.h"
#include "server/log/logger.h"

namespace penumbra {

class CallRecord {
 public:
  // `method` is the call's name, without its service's. Both others outlive the record.
  CallRecord(ServerCounters& counters, Logger& logger, std::string method);
  ~CallRecord();
  CallRecord(const CallRecord&) = delete;
  CallRecord& operator=(const CallRecord&) = delete;

  void End(const absl::Status& status);

 private:
  ServerCounters& counters_;
  Logger& logger_;
  const std::string method_;
  const uint64_t number_;  // "request" in the log
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  bool has_ended_ = false;
};

}  // namespace penumbra
