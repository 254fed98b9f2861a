#include "server/session/session_table.h"

#include <string>
#include <utility>

#include "render/scene/field_error.h"

namespace penumbra {

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
