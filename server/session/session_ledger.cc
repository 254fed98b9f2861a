#include "server/session/session_ledger.h"

#include <algorithm>

#include "server/log/refusal.h"

namespace penumbra {
namespace {

std::chrono::milliseconds Since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now() -
                                                               start);
}

}  // namespace

SessionRecord::SessionRecord(SessionLedger& ledger, uint64_t number)
    : ledger_(ledger), number_(number) {}

SessionRecord::~SessionRecord() {
  {
    std::lock_guard lock(ledger_.mutex_);
    ledger_.open_.erase(number_);
  }
  if (scene_id_.empty()) return;
  const absl::Status reason = end_.value_or(absl::OkStatus());
  const auto age = Since(opened_);
  ledger_.counters_.session_sent_bytes.Observe(static_cast<double>(sent_bytes_));
  ledger_.counters_.session_seconds.Observe(static_cast<double>(age.count()) * 1e-3);
  ledger_.logger_.Info("session_ended", {{"session", number_},
                                         {"scene", scene_id_},
                                         {"client", client_name_},
                                         {"reason", FailureReason(reason)},
                                         {"duration_ms", age.count()},
                                         {"commits", commits_.load()},
                                         {"updates_sent", updates_sent_.load()},
                                         {"updates_skipped", updates_skipped_.load()},
                                         {"sent_bytes", sent_bytes_.load()}});
}

void SessionRecord::Greet(const std::string& scene_id, const std::string& client_name) {
  {
    std::lock_guard lock(mutex_);
    scene_id_ = scene_id;
    client_name_ = client_name;
  }
  ledger_.logger_.Info("session_opened",
                       {{"session", number_}, {"scene", scene_id}, {"client", client_name}});
}

void SessionRecord::Refuse(std::string_view request, const absl::Status& status) {
  NoteRefusal(ledger_.counters_, ledger_.logger_, request, status, {{"session", number_}});
}

void SessionRecord::NoteOverQuota(const absl::Status& status) {
  const std::string reason = FailureReason(status);
  ledger_.counters_.CountFailure(reason);
  ledger_.logger_.Info("over_quota", {{"session", number_}, {"reason", reason}});
}

void SessionRecord::End(const absl::Status& reason) {
  bool was_greeted = false;
  {
    std::lock_guard lock(mutex_);
    if (end_) return;
    end_ = reason;
    was_greeted = !scene_id_.empty();
  }
  if (!was_greeted && !reason.ok() && !absl::IsCancelled(reason)) Refuse("hello", reason);
}

void SessionRecord::CountSent(uint64_t bytes) {
  sent_bytes_ += bytes;
  ledger_.counters_.sent_bytes += bytes;
}

void SessionRecord::CountUpdate(uint64_t skipped) {
  ++updates_sent_;
  updates_skipped_ += skipped;
  ++ledger_.counters_.updates_sent;
  ledger_.counters_.updates_skipped += skipped;
}

std::shared_ptr<SessionRecord> SessionLedger::Open() {
  std::shared_ptr<SessionRecord> record(new SessionRecord(*this, ++counters_.sessions_made));
  std::lock_guard lock(mutex_);
  open_.emplace(record->number(), record.get());
  return record;
}

std::vector<SessionSummary> SessionLedger::List() const {
  std::vector<SessionSummary> summaries;
  std::lock_guard lock(mutex_);
  for (const auto& [number, record] : open_) {
    std::lock_guard record_lock(record->mutex_);
    if (record->scene_id_.empty()) continue;
    summaries.push_back(
        {.number = number,
         .scene_id = record->scene_id_,
         .client_name = record->client_name_,
         .age = Since(record->opened_),
         .subscriptions = static_cast<uint64_t>(std::max<int64_t>(record->subscriptions_, 0)),
         .sent_bytes = record->sent_bytes_,
         .updates_sent = record->updates_sent_,
         .updates_skipped = record->updates_skipped_,
         .commits = record->commits_});
  }
  return summaries;
}

}  // namespace penumbra
