// Somebody whom the guard has let into a call. Only the guard makes one, so that what takes a
// Caller cannot be reached past it.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "absl/status/status.h"
#include "server/security/authenticator.h"
#include "server/security/identity.h"
#include "server/security/rpc_roles.h"

namespace penumbra {

class Caller {
 public:
  const Identity& identity() const { return identity_; }

  // Errors  those of Authorize in rpc_roles.h, for this caller
  absl::Status Authorize(std::string_view name,
                         std::optional<std::string_view> scene_id = std::nullopt) const {
    return penumbra::Authorize(name, identity_, scene_id);
  }

 private:
  friend class CallGuard;
  Caller(Identity identity, PresentedCredentials shown, uint64_t version)
      : identity_(std::move(identity)), shown_(std::move(shown)), version_(version) {}

  Identity identity_;
  PresentedCredentials shown_;
  uint64_t version_;  // of the files that they were checked against
};

}  // namespace penumbra
