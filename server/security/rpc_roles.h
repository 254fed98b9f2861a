// Who may call what: one table of every call of the service and of every request in a session, and
// the one function that decides by it. What is not in the table is refused.
//
// The build checks the table against the service's descriptor (check_rpc_roles.cc): it fails when a
// call or a kind of request has no row. docs/security.md shows the table; a test holds it to this.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "absl/status/status.h"
#include "server/security/identity.h"

namespace penumbra {

// What a call has to do with scenes, and so what a scope does to it.
enum class SceneRule {
  kNone,      // nothing
  kNamed,     // it names one: outside the scope there is none of that name
  kMade,      // it makes one: outside the scope it may not, whether there is one or not
  kListed,    // it lists them: those in the scope
  kContents,  // it reads blobs: those of scenes in the scope, and the caller's own uploads
};

struct RpcRole {
  std::string_view name;  // "CreateScene"; of a request in a session "Session.commit"
  Role least;
  SceneRule scene;
  std::string_view why;
};

// In the order of the service; the requests of a session after it.
std::span<const RpcRole> RpcRoles();

// Null for what is not in the table.
const RpcRole* FindRpcRole(std::string_view name);

// Whether `identity` may do `name`, to the scene of that id where there is one. Only kNamed and
// kMade look at the id.
//
// Errors  kPermissionDenied ROLE: too low a role, or not in the table; SCOPE: kMade out of scope;
//         kNotFound UNKNOWN_ID: kNamed out of scope, in the words used of a scene that is not there
absl::Status Authorize(std::string_view name, const Identity& identity,
                       std::optional<std::string_view> scene_id = std::nullopt);

}  // namespace penumbra
