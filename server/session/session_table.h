// The sessions that are open, to bound their number and to end them all when the server does.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "server/session/session.h"

namespace penumbra {

class SessionTable {
 public:
  explicit SessionTable(const ServerLimits& limits);
  ~SessionTable();

  // Errors  kResourceExhausted QUOTA_SESSIONS; after EndAll, its status
  absl::Status Add(std::weak_ptr<Session> session);
  // Lets no more sessions in: they end with `status`.
  void Close(const absl::Status& status);
  // Ends all sessions, those to come included.
  void EndAll(const absl::Status& status);

 private:
  void Sweep();

  const ServerLimits limits_;
  std::mutex mutex_;
  std::vector<std::weak_ptr<Session>> sessions_;
  std::optional<absl::Status> ended_;
  std::condition_variable is_over_;
  bool is_closing_ = false;
  std::thread sweeper_;  // lets go of those that take nothing
};

}  // namespace penumbra
