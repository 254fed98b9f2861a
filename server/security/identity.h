// Who someone is to this server: a name for the records, and what they may do where until when.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "server/security/role.h"
#include "server/security/scene_scope.h"

namespace penumbra {

struct Identity {
  std::string name;
  Role role = Role::kViewer;
  SceneScope scope = SceneScope::Everything();
  // Wall-clock time, the one thing here that is: whoever issues credentials knows no other.
  std::optional<std::chrono::system_clock::time_point> expires = std::nullopt;

  friend bool operator==(const Identity&, const Identity&) = default;
};

// Whoever reaches a server that was given no identities: it listens on this machine alone.
inline Identity LocalAdmin() { return {.name = "local", .role = Role::kAdmin}; }

}  // namespace penumbra
