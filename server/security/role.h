// What someone may do, from least to most: each role may do what those before it may.
#pragma once

#include <optional>
#include <string_view>

namespace penumbra {

enum class Role {
  kViewer,  // look at scenes, receive artifacts
  kEditor,  // change scenes, make and delete them
  kAdmin,   // what concerns the server and not one scene
};

constexpr std::string_view RoleName(Role role) {
  switch (role) {
    case Role::kViewer:
      return "viewer";
    case Role::kEditor:
      return "editor";
    case Role::kAdmin:
      return "admin";
  }
  return "";
}

constexpr std::optional<Role> RoleNamed(std::string_view name) {
  for (const Role role : {Role::kViewer, Role::kEditor, Role::kAdmin}) {
    if (RoleName(role) == name) return role;
  }
  return std::nullopt;
}

}  // namespace penumbra
