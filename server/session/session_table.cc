#include "server/session/session_table.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"
#include "render/scene/retry_delay.h"

namespace penumbra {
namespace {

// How late sessions may hear that their principal has used up its computing.
constexpr std::chrono::milliseconds kTellInterval{1'000};
// Until another one may have ended.
constexpr double kRoomMayComeMs = 1'000;

absl::Status TooMany(int64_t found, const char* what, uint32_t limit) {
  return WithRetryDelay(
      FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_SESSIONS", "",
                 absl::StrCat("found ", found, " ", what, " open, need fewer than ", limit,
                              " before another")),
      kRoomMayComeMs);
}

}  // namespace

SessionTable::SessionTable(const ServerLimits& limits, const PrincipalQuotas& quotas)
    : limits_(limits), quotas_(quotas), sweeper_([this] { Sweep(); }) {}

SessionTable::~SessionTable() {
  {
    std::lock_guard lock(mutex_);
    is_closing_ = true;
  }
  is_over_.notify_all();
  sweeper_.join();
}

void SessionTable::Sweep() {
  // Who is let go, a tenth late at most.
  const auto interval =
      std::min(kTellInterval, std::chrono::milliseconds{limits_.max_stall_seconds * 100});
  std::unique_lock lock(mutex_);
  while (!is_over_.wait_for(lock, interval, [this] { return is_closing_; })) {
    std::vector<std::shared_ptr<Session>> open;
    for (const Row& row : sessions_) {
      if (auto session = row.session.lock()) open.push_back(std::move(session));
    }
    lock.unlock();
    for (const auto& session : open) {
      session->EndIfStalled(std::chrono::steady_clock::now());
      session->TellOfCompute();
    }
    open.clear();
    lock.lock();
  }
}

absl::Status SessionTable::Add(std::weak_ptr<Session> session, const std::string& principal) {
  const uint32_t quota = quotas_.Of(principal).sessions;
  std::lock_guard lock(mutex_);
  if (ended_) return *ended_;
  std::erase_if(sessions_, [](const Row& row) { return row.session.expired(); });
  if (sessions_.size() >= limits_.max_sessions) {
    return TooMany(sessions_.size(), "sessions", limits_.max_sessions);
  }
  if (quota > 0) {
    const auto theirs = std::count_if(sessions_.begin(), sessions_.end(),
                                      [&](const Row& row) { return row.principal == principal; });
    if (theirs >= quota) return TooMany(theirs, "sessions of the same principal", quota);
  }
  sessions_.push_back({std::move(session), principal});
  return absl::OkStatus();
}

void SessionTable::Close(const absl::Status& status) {
  std::lock_guard lock(mutex_);
  ended_ = status;
}

void SessionTable::EndAll(const absl::Status& status) {
  std::vector<Row> sessions;
  {
    std::lock_guard lock(mutex_);
    ended_ = status;
    sessions.swap(sessions_);
  }
  for (const Row& row : sessions) {
    if (const auto session = row.session.lock()) session->End(status);
  }
}

}  // namespace penumbra
