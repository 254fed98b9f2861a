// The sessions that are open, to bound their number and to end them all when the server does.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "server/session/session.h"

namespace penumbra {

class SessionTable {
 public:
  SessionTable(const ServerLimits& limits, const PrincipalQuotas& quotas);
  ~SessionTable();

  // Errors  kResourceExhausted QUOTA_SESSIONS, of the server or of the session's principal, with a
  //         retry delay; after EndAll, its status
  absl::Status Add(std::weak_ptr<Session> session, const std::string& principal);
  // Lets no more sessions in: they end with `status`.
  void Close(const absl::Status& status);
  // Ends all sessions, those to come included.
  void EndAll(const absl::Status& status);

 private:
  struct Row {
    std::weak_ptr<Session> session;
    std::string principal;
  };

  void Sweep();

  const ServerLimits limits_;
  const PrincipalQuotas& quotas_;
  std::mutex mutex_;
  std::vector<Row> sessions_;
  std::optional<absl::Status> ended_;
  std::condition_variable is_over_;
  bool is_closing_ = false;
  std::thread sweeper_;  // lets go of those that take nothing, and tells of quotas
};

}  // namespace penumbra
