// Who calls, found from what they show. Any thread may ask; Reload swaps what it asks of.
//
//   auto authenticator = Authenticator::Create({.tokens_file = "tokens"});
//   auto identity = (*authenticator)->Authenticate({.authorizations = {"Bearer penumbra_…"}});
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/security/identity.h"
#include "server/security/identity_file.h"
#include "server/security/jwt.h"

namespace penumbra {

struct AuthenticatorOptions {
  std::string tokens_file;    // see identity_file.h; empty: none
  std::string jwt_keys_file;  // see jwt_keys.h; empty: none
  JwtRules jwt;
  std::function<std::chrono::system_clock::time_point()> now = std::chrono::system_clock::now;
};

// What came with a call.
struct PresentedCredentials {
  std::vector<std::string> authorizations;  // each value of the header "authorization"
  std::vector<std::string> certificate_names;  // of a client certificate: "cn:…", "dns:…", "uri:…"
};

class Authenticator {
 public:
  // Errors  kInvalidArgument: a file that cannot be read or understood; issuer or audience missing
  static absl::StatusOr<std::unique_ptr<Authenticator>> Create(AuthenticatorOptions options);

  // Nobody has to show anything: the server was given no identities.
  bool is_open() const { return options_.tokens_file.empty() && options_.jwt_keys_file.empty(); }

  // Errors  kUnauthenticated: why, for the server's records; callers hear one text whatever it was
  absl::StatusOr<Identity> Authenticate(const PresentedCredentials& shown) const;

  // Another one whenever the files have said something new.
  uint64_t version() const { return version_; }
  std::chrono::system_clock::time_point now() const { return options_.now(); }

  // Reads the files again, and takes them over once they have been the same twice: a file that is
  // being written is not half believed. What cannot be understood changes nothing.
  //
  // Errors  those of Create
  absl::Status Reload();

 private:
  struct Known {
    IdentityFile identities;
    JwtKeys keys;
  };
  // The files' texts; empty where there is no file.
  struct Texts {
    std::string tokens;
    std::string keys;
    friend bool operator==(const Texts&, const Texts&) = default;
  };
  explicit Authenticator(AuthenticatorOptions options) : options_(std::move(options)) {}
  absl::StatusOr<Texts> Read() const;
  absl::Status Take(const Texts& texts);
  std::shared_ptr<const Known> known() const;
  absl::StatusOr<Identity> AuthenticateText(const std::string& authorization,
                                            const Known& known) const;

  const AuthenticatorOptions options_;
  mutable std::mutex mutex_;
  std::shared_ptr<const Known> known_;  // guarded by mutex_
  std::atomic<uint64_t> version_{0};
  Texts seen_;   // when last looked; for Reload's thread alone, as the next
  Texts taken_;  // what known_ was made of, or could not be
};

}  // namespace penumbra
