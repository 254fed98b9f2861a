// All that stands between the network and the service, and the thread that keeps it up to date.
//
//   auto security = ServerSecurity::Create(options);
//   auto caller = (*security)->guard().Admit(*context, "ListScenes");
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "absl/status/statusor.h"
#include "grpcpp/security/server_credentials.h"
#include "server/security/authenticator.h"
#include "server/security/call_guard.h"
#include "server/security/connection_table.h"
#include "server/security/live_calls.h"
#include "server/security/security_options.h"
#include "server/security/tls_identity.h"

namespace penumbra {

class ServerSecurity {
 public:
  // Errors  those of Authenticator::Create and TlsIdentity::Load
  static absl::StatusOr<std::unique_ptr<ServerSecurity>> Create(const SecurityOptions& options);
  ~ServerSecurity();

  const CallGuard& guard() const { return guard_; }
  ConnectionTable& connections() { return connections_; }
  // For the one listener. Must not be used after this object.
  std::shared_ptr<grpc::ServerCredentials> MakeCredentials();

 private:
  ServerSecurity(const SecurityOptions& options, std::unique_ptr<Authenticator> authenticator,
                 std::unique_ptr<TlsIdentity> tls);
  void Watch();
  // Tells of what is wrong once, not each time it is looked at.
  void Report(const absl::Status& status, std::string& last);

  const SecurityOptions options_;
  const std::unique_ptr<Authenticator> authenticator_;
  const std::unique_ptr<TlsIdentity> tls_;  // null: without TLS
  ConnectionTable connections_;
  LiveCalls calls_;
  const CallGuard guard_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_ending_ = false;  // guarded by mutex_
  std::thread watch_;
};

}  // namespace penumbra
