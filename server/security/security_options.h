// How a server is protected: who may use it, and over what.
#pragma once

#include <functional>
#include <string>

#include "absl/status/status.h"
#include "server/security/authenticator.h"
#include "server/security/call_guard.h"
#include "server/security/connection_table.h"
#include "server/security/tls_identity.h"

namespace CLI {
class App;
}

namespace penumbra {

struct SecurityOptions {
  AuthenticatorOptions identities;
  TlsFiles tls;
  ConnectionLimits connections;
  // How often files are looked at and rights asked anew. A right that ends has its streams ended
  // within twice this and two seconds.
  std::chrono::milliseconds look_interval{1'000};
  // Told, on other threads, of files that have become wrong, and of calls without credentials. May
  // be null. Nothing that it is told holds a credential.
  std::function<void(const std::string&)> on_problem = nullptr;
  CallGuard::OnRefused on_refused = nullptr;
};

// Whether the options go together with an address to listen on.
//
// Errors  kInvalidArgument: those of CheckListenAddress; NEEDS_IDENTITIES: other machines can reach
//         it, and everyone would be an admin; MISSING_FIELD: --tls-client-ca without --tls-…,
//         --jwt-issuer or --jwt-audience without --jwt-keys
absl::Status CheckSecurity(const SecurityOptions& options, const std::string& listen);

// The options of the command line. `options` must outlive the parsing.
void AddSecurityOptions(CLI::App& app, SecurityOptions& options);

}  // namespace penumbra
