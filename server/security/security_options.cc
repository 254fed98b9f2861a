#include "server/security/security_options.h"

#include <CLI/CLI.hpp>

#include "render/scene/field_error.h"
#include "server/listen_address.h"

namespace penumbra {
namespace {

// Whoever says what tokens must be like believes that they are asked for.
absl::Status CheckJwtRules(const AuthenticatorOptions& identities) {
  const bool has_rules = !identities.jwt.issuer.empty() || !identities.jwt.audience.empty();
  if (!has_rules || !identities.jwt_keys_file.empty()) return absl::OkStatus();
  return FieldError(absl::StatusCode::kInvalidArgument, "MISSING_FIELD", "jwt-keys",
                    "found none, need it with --jwt-issuer and --jwt-audience: without keys no "
                    "such token is asked for");
}

}  // namespace

absl::Status CheckSecurity(const SecurityOptions& options, const std::string& listen) {
  const bool has_tls = !options.tls.empty();
  if (auto status = CheckListenAddress(listen, has_tls); !status.ok()) return status;
  const auto& identities = options.identities;
  if (auto status = CheckJwtRules(identities); !status.ok()) return status;
  const bool is_open = identities.tokens_file.empty() && identities.jwt_keys_file.empty();
  if (is_open && !IsLocalAddress(listen)) {
    return FieldError(absl::StatusCode::kInvalidArgument, "NEEDS_IDENTITIES", "listen",
                      "found '" + listen +
                          "', where anyone would be an admin, need --tokens or --jwt-keys to be "
                          "reached from other machines");
  }
  if (is_open && !options.tls.client_ca.empty()) {
    return FieldError(absl::StatusCode::kInvalidArgument, "NEEDS_IDENTITIES", "tls-client-ca",
                      "found no --tokens, need a file that says what each certificate may do");
  }
  return absl::OkStatus();
}

void AddSecurityOptions(CLI::App& app, SecurityOptions& options) {
  const auto add = [&app](const char* name, std::string& value, const char* help) {
    app.add_option(name, value, help)->group("Security");
  };
  add("--tls-certificate", options.tls.certificate,
      "PEM file of the server's certificate; needed where other machines connect");
  add("--tls-key", options.tls.key, "PEM file of its key, without a passphrase");
  add("--tls-client-ca", options.tls.client_ca,
      "PEM file of who signs clients' certificates: every client must show one");
  add("--tokens", options.identities.tokens_file,
      "File of who may do what (see `penumbrad token --help`). Without it and --jwt-keys everyone "
      "on this machine is an admin");
  add("--jwt-keys", options.identities.jwt_keys_file,
      "JSON Web Key Set that signs tokens (RS256, ES256)");
  add("--jwt-issuer", options.identities.jwt.issuer, "Who must have issued them");
  add("--jwt-audience", options.identities.jwt.audience, "Whom they must be for");
  app.add_option("--max-connections", options.connections.max_connections,
                 "At a time; 0, and at most: half of the descriptors that the process may have")
      ->check(CLI::Range(0, 1 << 20))
      ->capture_default_str()
      ->group("Security");
  app.add_option("--max-connections-per-address", options.connections.max_connections_per_address,
                 "At a time, from one address that is not this machine's")
      ->check(CLI::Range(1, 1 << 20))
      ->capture_default_str()
      ->group("Security");
}

}  // namespace penumbra
