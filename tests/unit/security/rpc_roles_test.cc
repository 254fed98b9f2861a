#include "server/security/rpc_roles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/scene/field_error.h"

namespace penumbra {
namespace {

Identity Of(Role role, const char* pattern = "*") {
  return {.name = "ana", .role = role, .scope = SceneScope::Create({pattern}).value()};
}

TEST(RpcRolesTest, E04WhatIsNotInTheTableIsDeniedToAll) {
  for (const char* name : {"", "Shutdown", "createscene", "Session.", "Session.undo"}) {
    EXPECT_EQ(FindRpcRole(name), nullptr);
    const auto status = Authorize(name, Of(Role::kAdmin));
    EXPECT_EQ(status.code(), absl::StatusCode::kPermissionDenied) << name;
    EXPECT_EQ(ErrorReason(status), "ROLE");
  }
}

TEST(RpcRolesTest, ARoleIncludesThoseBeforeIt) {
  EXPECT_EQ(Authorize("ListScenes", Of(Role::kViewer)), absl::OkStatus());
  EXPECT_EQ(ErrorReason(Authorize("CreateScene", Of(Role::kViewer), "a")), "ROLE");
  EXPECT_EQ(Authorize("CreateScene", Of(Role::kEditor), "a"), absl::OkStatus());
  EXPECT_EQ(Authorize("CreateScene", Of(Role::kAdmin), "a"), absl::OkStatus());
  EXPECT_EQ(ErrorReason(Authorize("Session.commit", Of(Role::kViewer))), "ROLE");
}

TEST(RpcRolesTest, E02OutOfScopeThereIsNothing) {
  const Identity editor = Of(Role::kEditor, "review-*");
  EXPECT_EQ(Authorize("DeleteScene", editor, "review-1"), absl::OkStatus());
  const auto hidden = Authorize("DeleteScene", editor, "studio");
  EXPECT_EQ(hidden.code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(ErrorReason(hidden), "UNKNOWN_ID");
  EXPECT_EQ(ErrorReason(Authorize("CreateScene", editor, "studio")), "SCOPE");
  EXPECT_EQ(ErrorReason(Authorize("DeleteScene", editor, "a/b")), "BAD_ID");
  // An admin's scope is one too.
  EXPECT_EQ(Authorize("DeleteScene", Of(Role::kAdmin, "review-*"), "studio").code(),
            absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace penumbra
