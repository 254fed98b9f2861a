#include "server/session/session_table.h"

#include <chrono>
#include <string>
#include <utility>

#include "render/scene/field_error.h"

namespace penumbra {

SessionTable::SessionTable(const ServerLimits& limits)
    : limits_(limits), sweeper_([this] { Sweep(); }) {}

SessionTable::~SessionTable() {
  {
    std::lock_guard lock(mutex_);
    is_closing_ = true;
  }
  is_over_.notify_all();
  sweeper_.join();
}

void SessionTable::Sweep() {
  // A tenth late at most.
  const std::chrono::milliseconds interval{limits_.max_stall_seconds * 100};
  std::unique_lock lock(mutex_);
  while (!is_over_.wait_for(lock, interval, [this] { return is_closing_; })) {
    std::vector<std::shared_ptr<Session>> open;
    for (const auto& weak : sessions_) {
      if (auto session = weak.lock()) open.push_back(std::move(session));
    }
    lock.unlock();
    for (const auto& session : open) session->EndIfStalled(std::chrono::steady_clock::now());
    open.clear();
    lock.lock();
  }
}

absl::Status SessionTable::Add(std::weak_ptr<Session> session) {
  std::lock_guard lock(mutex_);
  if (ended_) return *ended_;
  std::erase_if(sessions_, [](const auto& weak) { return weak.expired(); });
  if (sessions_.size() >= limits_.max_sessions) {
    return FieldError(
        absl::StatusCode::kResourceExhausted, "QUOTA_SESSIONS", "",
        "found " + std::to_string(sessions_.size()) + " sessions open, need fewer before another");
  }
  sessions_.push_back(std::move(session));
  return absl::OkStatus();
}

void SessionTable::Close(const absl::Status& status) {
  std::lock_guard lock(mutex_);
  ended_ = status;
}

void SessionTable::EndAll(const absl::Status& status) {
  std::vector<std::weak_ptr<Session>> sessions;
  {
    std::lock_guard lock(mutex_);
    ended_ = status;
    sessions.swap(sessions_);
  }
  for (const auto& weak : sessions) {
    if (const auto session = weak.lock()) session->End(status);
  }
}

}  // namespace penumbra
