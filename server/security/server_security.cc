#include "server/security/server_security.h"

#include <utility>

namespace penumbra {

absl::StatusOr<std::unique_ptr<ServerSecurity>> ServerSecurity::Create(
    const SecurityOptions& options) {
  auto authenticator = Authenticator::Create(options.identities);
  if (!authenticator.ok()) return authenticator.status();
  std::unique_ptr<TlsIdentity> tls;
  if (!options.tls.empty()) {
    auto loaded = TlsIdentity::Load(options.tls);
    if (!loaded.ok()) return loaded.status();
    tls = *std::move(loaded);
  }
  return std::unique_ptr<ServerSecurity>(
      new ServerSecurity(options, *std::move(authenticator), std::move(tls)));
}

ServerSecurity::ServerSecurity(const SecurityOptions& options,
                               std::unique_ptr<Authenticator> authenticator,
                               std::unique_ptr<TlsIdentity> tls)
    : options_(options),
      authenticator_(std::move(authenticator)),
      tls_(std::move(tls)),
      connections_(options.connections),
      guard_(*authenticator_, connections_, calls_, options.on_refused),
      watch_([this] { Watch(); }) {}

ServerSecurity::~ServerSecurity() {
  {
    std::lock_guard lock(mutex_);
    is_ending_ = true;
  }
  changed_.notify_all();
  watch_.join();
}

std::shared_ptr<grpc::ServerCredentials> ServerSecurity::MakeCredentials() {
  return tls_ ? tls_->MakeCredentials() : grpc::InsecureServerCredentials();
}

void ServerSecurity::Report(const absl::Status& status, std::string& last) {
  const std::string text(status.message());
  if (text != last && !status.ok() && options_.on_problem) options_.on_problem(text);
  last = text;
}

void ServerSecurity::Watch() {
  std::string last_of_identities, last_of_tls;
  std::unique_lock lock(mutex_);
  while (!changed_.wait_for(lock, options_.look_interval, [this] { return is_ending_; })) {
    lock.unlock();
    Report(authenticator_->Reload(), last_of_identities);
    if (tls_) Report(tls_->Reload(), last_of_tls);
    const auto now = std::chrono::steady_clock::now();
    calls_.Sweep(now);
    connections_.Sweep(now);
    lock.lock();
  }
}

}  // namespace penumbra
