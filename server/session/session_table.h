// The sessions that are open, to bound their number and to end them all when the server does.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "server/session/session.h"

namespace penumbra {

class SessionTable {
 public:
  explicit SessionTable(const ServerLimits& limits) : limits_(limits) {}

  // Errors  kResourceExhausted QUOTA_SESSIONS; after EndAll, its status
  absl::Status Add(std::weak_ptr<Session> session);
  // Lets no more sessions in: they end with `status`.
  void Close(const absl::Status& status);
  // Ends all sessions, those to come included.
  void EndAll(const absl::Status& status);

 private:
  const ServerLimits limits_;
  std::mutex mutex_;
  std::vector<std::weak_ptr<Session>> sessions_;
  std::optional<absl::Status> ended_;
};

}  // namespace penumbra
