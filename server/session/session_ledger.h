// Who is connected: for the log, the metrics, and GetServerStatus.
//
//   auto record = ledger.Open();                 // by a session, for as long as it lives
//   record->Greet("studio", "penumbra watch");   // its hello was accepted
//   record->CountSent(message.Length());
//   record->End(status);                         // why it is over; the first counts
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "server/counters.h"
#include "server/log/logger.h"

namespace penumbra {

class SessionLedger;

// What one session is and has done. Any thread may use it.
class SessionRecord {
 public:
  ~SessionRecord();
  SessionRecord(const SessionRecord&) = delete;
  SessionRecord& operator=(const SessionRecord&) = delete;

  // Of the sessions since the server's start; what the log calls it.
  uint64_t number() const { return number_; }

  void Greet(const std::string& scene_id, const std::string& client_name);
  // A request of it was refused; `request` is the protocol's word for its kind.
  void Refuse(std::string_view request, const absl::Status& status);
  // Nothing of it was refused: its principal has used up what it is sure of.
  void NoteOverQuota(const absl::Status& status);
  void End(const absl::Status& reason);

  void CountSent(uint64_t bytes);
  // An update has gone out whole, after so many that newer ones took the place of.
  void CountUpdate(uint64_t skipped);
  void CountCommit() { ++commits_; }
  void CountSubscriptions(int64_t more) { subscriptions_ += more; }

 private:
  friend class SessionLedger;
  SessionRecord(SessionLedger& ledger, uint64_t number);

  SessionLedger& ledger_;
  const uint64_t number_;
  const std::chrono::steady_clock::time_point opened_ = std::chrono::steady_clock::now();
  std::atomic<uint64_t> sent_bytes_{0};
  std::atomic<uint64_t> updates_sent_{0};
  std::atomic<uint64_t> updates_skipped_{0};
  std::atomic<uint64_t> commits_{0};
  std::atomic<int64_t> subscriptions_{0};

  mutable std::mutex mutex_;  // guards all below
  std::string scene_id_;      // empty before the hello
  std::string client_name_;
  std::optional<absl::Status> end_;
};

// What a session's record says at one moment.
struct SessionSummary {
  uint64_t number = 0;
  std::string scene_id;
  std::string client_name;
  std::chrono::milliseconds age{};
  uint64_t subscriptions = 0;
  uint64_t sent_bytes = 0;
  uint64_t updates_sent = 0;
  uint64_t updates_skipped = 0;
  uint64_t commits = 0;
};

class SessionLedger {
 public:
  // Both outlive it, and it outlives the records.
  SessionLedger(ServerCounters& counters, Logger& logger) : counters_(counters), logger_(logger) {}

  std::shared_ptr<SessionRecord> Open();
  // Of sessions whose hello was accepted, by number.
  std::vector<SessionSummary> List() const;

 private:
  friend class SessionRecord;

  ServerCounters& counters_;
  Logger& logger_;
  mutable std::mutex mutex_;  // taken before a record's
  std::map<uint64_t, SessionRecord*> open_;
};

}  // namespace penumbra
