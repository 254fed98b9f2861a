// Whoever may only look is seen, sees, and does not edit.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/session/remote_engine.h"
#include "client/session/scene_presence.h"
#include "render/scene/field_error.h"
#include "tests/integration/security/guarded_server.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

TEST(PresenceRoleTest, AViewerIsPresentAndEditsNothing) {
  GuardedServer server;
  const std::string edits = server.Admit("ana", "editor", "*");
  const std::string looks = server.Admit("vera", "viewer", "*");
  server.Start();
  const auto connect = [&](const std::string& token) {
    return RemoteEngine::Connect({.address = server.address(), .credentials = {.token = token}});
  };
  const auto ana = connect(edits), vera = connect(looks);
  ASSERT_TRUE(ana.ok() && vera.ok()) << ana.status() << vera.status();
  ASSERT_EQ((*ana)->CreateScene("studio"), absl::OkStatus());
  const auto editor = (*ana)->Enter("studio", {.display_name = "Ana"}, nullptr);
  const auto viewer = (*vera)->Enter("studio", {.display_name = "Vera"}, nullptr);
  ASSERT_TRUE(editor.ok() && viewer.ok()) << editor.status() << viewer.status();
  ASSERT_EQ((*viewer)->attendance().others.size(), 1u);
  EXPECT_EQ((*viewer)->attendance().others[0].presence.display_name, "Ana");
  EXPECT_EQ((*viewer)->Report({.display_name = "Vera", .colour_rgb = 3}), absl::OkStatus());

  for (const absl::Status& refused :
       {(*viewer)->TakeEditing(), (*viewer)->TakeEditing(true), (*viewer)->ReleaseEditing(),
        (*viewer)->HandOverEditing((*viewer)->attendance().own_id)}) {
    EXPECT_EQ(refused.code(), absl::StatusCode::kPermissionDenied) << refused;
    EXPECT_EQ(ErrorReason(refused), "ROLE");
  }
  SceneDelta delta;
  delta.upsert_instances = {{.id = "box", .mesh = MeshOf(UnitBoxGeometry())}};
  EXPECT_FALSE((*vera)->Commit("studio", delta).ok());
  ASSERT_EQ((*editor)->TakeEditing(), absl::OkStatus()) << "nothing was taken";
  ASSERT_EQ((*editor)->HandOverEditing((*viewer)->attendance().own_id), absl::OkStatus());
  EXPECT_EQ((*vera)->Commit("studio", {}).status().code(), absl::StatusCode::kPermissionDenied)
      << "the one editor needs the right besides";
  ASSERT_EQ((*editor)->TakeEditing(/*from_other=*/true), absl::OkStatus());
  EXPECT_TRUE((*ana)->Commit("studio", delta).ok());
}

}  // namespace
}  // namespace penumbra::testing
