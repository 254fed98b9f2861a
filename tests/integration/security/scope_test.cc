// E02 and E15: whoever may not know of a scene is told what is told of one that does not exist.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_replace.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/field_error.h"
#include "tests/integration/security/guarded_server.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

using ::testing::ElementsAre;

class ScopeTest : public ::testing::Test {
 protected:
  void SetUp() override {
    admin_ = server_.Admit("root", "admin", "*");
    editor_ = server_.Admit("ana", "editor", "review-*");
    other_ = server_.Admit("ben", "editor", "other-*");
    server_.Start();
    ASSERT_EQ(Admin().Create("secret"), absl::OkStatus());
    ASSERT_EQ(Admin().Create("review-1"), absl::OkStatus());
  }
  Visitor Admin() { return server_.Visit(admin_); }
  Visitor Ana() { return server_.Visit(editor_); }

  static absl::Status HelloOn(Visitor visitor, const std::string& scene_id) {
    const auto session = visitor.Open("Session");
    return visitor.Hello(*session, scene_id);
  }

  // Puts a box into a scene, whose blob has been uploaded or is there.
  static absl::Status Place(Visitor& visitor, const std::string& scene_id, const Mesh& mesh) {
    const auto session = visitor.Open("Session");
    if (auto status = visitor.Hello(*session, scene_id); !status.ok()) return status;
    v1::SceneDelta delta;
    SceneDelta domain;
    domain.upsert_instances = {{.id = "box", .mesh = MeshOf(mesh.geometry())}};
    return visitor.Commit(*session, ToProto(domain));
  }

  GuardedServer server_;
  std::string admin_, editor_, other_;
};

// The answer about "absent", with another scene's name in it.
absl::Status Renamed(const absl::Status& status, const std::string& name) {
  return FieldError(
      status.code(), ErrorReason(status), ErrorFieldPath(status),
      absl::StrReplaceAll(std::string(status.message()).substr(ErrorFieldPath(status).size() + 2),
                          {{"absent", name}}));
}

TEST_F(ScopeTest, E15ASceneOutOfScopeIsAsOneThatIsNotThere) {
  const auto deleted = Ana().Delete("secret");
  EXPECT_EQ(deleted.code(), absl::StatusCode::kNotFound);
  // Both in the words that an admin hears of a scene that is not there.
  EXPECT_EQ(deleted, Renamed(Admin().Delete("absent"), "secret"));
  EXPECT_EQ(deleted, Renamed(Ana().Delete("absent"), "secret"));
  const auto opened = HelloOn(Ana(), "secret");
  EXPECT_EQ(opened.code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(ErrorFieldPath(opened), "hello.scene_id");
  EXPECT_EQ(opened, Renamed(HelloOn(Admin(), "absent"), "secret"));
  EXPECT_EQ(opened, Renamed(HelloOn(Ana(), "absent"), "secret"));
  // Making one says nothing of whether there is one.
  const auto made = Ana().Create("secret");
  EXPECT_EQ(made.code(), absl::StatusCode::kPermissionDenied);
  EXPECT_EQ(ErrorReason(made), "SCOPE");
  EXPECT_EQ(made, Renamed(Ana().Create("absent"), "secret"));
  const auto exported = Ana().Export("secret");
  EXPECT_EQ(exported.code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(exported, Renamed(Admin().Export("absent"), "secret"));
  EXPECT_EQ(exported, Renamed(Ana().Export("absent"), "secret"));
  const auto imported = Ana().Import("secret");
  EXPECT_EQ(ErrorReason(imported), "SCOPE");
  EXPECT_EQ(imported, Renamed(Ana().Import("absent"), "secret"));
  // It is still there.
  EXPECT_THAT(Admin().List(), ElementsAre("review-1", "secret"));
}

TEST_F(ScopeTest, E02InScopeARoleThatIsTooLowIsDenied) {
  const std::string viewer = server_.Admit("vi", "viewer", "review-*");
  Visitor vi = server_.Visit(viewer);
  while (absl::IsUnauthenticated(vi.Call("ListScenes", v1::ListScenesRequest()))) {
  }
  EXPECT_EQ(vi.Delete("review-1").code(), absl::StatusCode::kPermissionDenied);
  const auto session = vi.Open("Session");
  ASSERT_EQ(vi.Hello(*session, "review-1"), absl::OkStatus());
  const auto status = vi.Commit(*session, v1::SceneDelta());
  EXPECT_EQ(status.code(), absl::StatusCode::kPermissionDenied);
  EXPECT_EQ(ErrorReason(status), "ROLE");
}

TEST_F(ScopeTest, OnlyScenesInScopeAreListed) {
  EXPECT_THAT(Ana().List(), ElementsAre("review-1"));
  EXPECT_THAT(server_.Visit(other_).List(), ElementsAre());
  EXPECT_THAT(Admin().List(), ElementsAre("review-1", "secret"));
}

TEST_F(ScopeTest, CountersOverAllScenesAreForThoseWhoMaySeeAll) {
  v1::GetServerInfoResponse info;
  ASSERT_EQ(Admin().Call("GetServerInfo", v1::GetServerInfoRequest(), &info), absl::OkStatus());
  EXPECT_TRUE(info.has_statistics());
  info.Clear();
  ASSERT_EQ(Ana().Call("GetServerInfo", v1::GetServerInfoRequest(), &info), absl::OkStatus());
  EXPECT_FALSE(info.has_statistics());
  EXPECT_GT(info.limits().max_message_bytes(), 0u);
}

TEST_F(ScopeTest, E15BlobsOfOtherScenesAreNotThere) {
  const auto box = MeshOf(UnitBoxGeometry());
  Visitor admin = Admin(), ana = Ana(), ben = server_.Visit(other_);
  ASSERT_EQ(admin.Upload(*box), absl::OkStatus());
  ASSERT_EQ(Place(admin, "secret", *box), absl::OkStatus());

  const auto is_missing = [&](Visitor& visitor) {
    v1::FindMissingBlobsRequest request;
    request.add_hashes(ToProto(box->id()));
    v1::FindMissingBlobsResponse response;
    EXPECT_EQ(visitor.Call("FindMissingBlobs", request, &response), absl::OkStatus());
    return response.missing_hashes_size() == 1;
  };
  EXPECT_TRUE(is_missing(ana));
  EXPECT_FALSE(is_missing(admin));
  const auto absent = ana.Download(*MeshOf(UnitSquareGeometry()));
  const auto hidden = ana.Download(*box);
  EXPECT_EQ(hidden.code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(ErrorReason(hidden), ErrorReason(absent));
  EXPECT_EQ(hidden.message().size(), absent.message().size()) << "the hash apart, the same text";
  // Knowing its name is not having it.
  EXPECT_EQ(ErrorReason(Place(ana, "review-1", *box)), "MISSING_BLOB");
  // Whoever has the bytes has the blob, and by then so has everyone in the scene.
  ASSERT_EQ(ana.Upload(*box), absl::OkStatus());
  EXPECT_FALSE(is_missing(ana));
  EXPECT_EQ(ana.Download(*box), absl::OkStatus());
  EXPECT_EQ(Place(ana, "review-1", *box), absl::OkStatus());
  EXPECT_TRUE(is_missing(ben));
  EXPECT_EQ(ben.Download(*box).code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace penumbra::testing
