// What each principal may use, told by who they are. Row C21: the culprit alone.

#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <thread>

#include "proto/convert/scene_convert.h"
#include "proto/convert/spec_convert.h"
#include "proto/convert/status_convert.h"
#include "render/scene/blob.h"
#include "render/scene/field_error.h"
#include "render/scene/retry_delay.h"
#include "tests/integration/security/guarded_server.h"
#include "tests/support/faulty_vfs.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

class QuotaTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ana_ = server_.Admit("ana", "admin", "*");
    ben_ = server_.Admit("ben", "admin", "*");
  }
  Visitor Ana() { return server_.Visit(ana_); }
  Visitor Ben() { return server_.Visit(ben_); }
  static void ExpectRefused(const absl::Status& status, const std::string& reason,
                            const std::string& number) {
    EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
    EXPECT_EQ(ErrorReason(status), reason) << status;
    EXPECT_NE(std::string(status.message()).find(number), std::string::npos) << status;
  }

  static SceneDelta Studio(const std::shared_ptr<const Mesh>& mesh) {
    SceneDelta delta;
    delta.upsert_instances = {
        {.id = "box", .mesh = mesh, .world_from_mesh = Placed({0, 1, 0}, 0.3f)}};
    delta.upsert_lights = {
        {.id = "lamp",
         .shape = RectangleLight{
             .corner = {-0.5f, 3, -0.5f}, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}}}};
    delta.upsert_receivers = {FloorReceiver("floor", 4.0f, 256)};
    return delta;
  }
  static v1::SessionRequest SubscribeToFloor() {
    v1::SessionRequest request;
    request.mutable_subscribe()->set_subscription_id(1);
    *request.mutable_subscribe()->mutable_spec() = ToProto(ArtifactSpec{
        .params = SoftTextureParams{.samples = 1'024}, .light_id = "lamp", .receiver_id = "floor"});
    request.mutable_subscribe()->set_initial_credit(1'000);
    return request;
  }

  GuardedServer server_;
  std::string ana_, ben_;
};

TEST_F(QuotaTest, C21ScenesAreCountedForWhoMadeThemAcrossRestarts) {
  ServerOptions options = server_.Options();
  options.data_dir = server_.Path("data");
  options.quotas.each.scenes = 2;
  server_.Start(options);
  EXPECT_EQ(Ana().Create("a"), absl::OkStatus());
  EXPECT_EQ(Ana().Create("b"), absl::OkStatus());
  ExpectRefused(Ana().Create("c"), "QUOTA_SCENES", "found 2 scenes");
  EXPECT_EQ(ErrorFieldPath(Ana().Create("c")), "scene_id");
  ExpectRefused(Ana().Import("c"), "QUOTA_SCENES", "found 2 scenes");
  EXPECT_EQ(Ben().Create("c"), absl::OkStatus());
  const absl::Status imported = Ben().Import("e");
  EXPECT_FALSE(imported.ok());
  EXPECT_NE(ErrorReason(imported), "QUOTA_SCENES") << imported;
  EXPECT_EQ(Ben().Create("e"), absl::OkStatus()) << "what came to nothing does not count";
  server_.Stop();
  server_.Start(options);
  ExpectRefused(Ana().Create("d"), "QUOTA_SCENES", "found 2 scenes");
  EXPECT_EQ(Ben().Delete("a"), absl::OkStatus()) << "whoever deletes it";
  EXPECT_EQ(Ana().Create("d"), absl::OkStatus());
}

TEST_F(QuotaTest, C21BlobsAreCountedForWhoBroughtThem) {
  const auto one = MeshOf(UnitBoxGeometry());
  MeshGeometry moved = UnitBoxGeometry();
  moved.positions[0].x += 0.25f;
  const auto other = MeshOf(moved);
  const uint64_t bytes = EncodeBlob(one->geometry()).size();
  ServerOptions options = server_.Options();
  options.quotas.each.blob_bytes = 2 * bytes - 1;
  server_.Start(options);
  EXPECT_EQ(Ana().Upload(*one), absl::OkStatus());
  const absl::Status over = Ana().Upload(*other);
  ExpectRefused(over, "QUOTA_BLOB_BYTES", "of the same owner");
  EXPECT_EQ(ErrorFieldPath(over), "header.size_bytes");
  EXPECT_EQ(Ben().Upload(*other), absl::OkStatus());
}

TEST_F(QuotaTest, C20SessionsAreCountedForWhoHasThemOpen) {
  ServerOptions options = server_.Options();
  options.quotas.named = {"ana:sessions=1"};
  server_.Start(options);
  ASSERT_EQ(Ana().Create("s"), absl::OkStatus());
  Visitor ana = Ana(), ben = Ben();
  const auto first = ana.Open("Session");
  ASSERT_EQ(ana.Hello(*first, "s"), absl::OkStatus());
  const auto second = ana.Open("Session");
  const absl::Status over = ana.Hello(*second, "s");
  ExpectRefused(over, "QUOTA_SESSIONS", "fewer than 1");
  EXPECT_TRUE(RetryDelayMs(over));
  const auto another = ben.Open("Session");
  EXPECT_EQ(ben.Hello(*another, "s"), absl::OkStatus());
  EXPECT_EQ(ana.Commit(*first, ToProto(SceneDelta{})), absl::OkStatus()) << "the first goes on";
}

TEST_F(QuotaTest, C21WhoHasMuchOnItsWayToTheDiskLeavesRoomForOthers) {
  FaultyVfs disk;
  v1::SessionRequest commit;
  *commit.mutable_commit()->mutable_delta() =
      ToProto(SceneDelta{.upsert_lights = Studio(MeshOf(UnitBoxGeometry())).upsert_lights});
  ServerOptions options = server_.Options();
  options.data_dir = server_.Path("data");
  options.storage.database.vfs = disk.name();
  options.limits.max_all_pending_commit_bytes = 4 * commit.commit().delta().ByteSizeLong();
  options.limits.max_commit_delay_ms = 60'000;
  server_.Start(options);
  Visitor ana = Ana(), ben = Ben();
  ASSERT_EQ(ana.Create("a"), absl::OkStatus());
  ASSERT_EQ(ben.Create("b"), absl::OkStatus());
  const auto of_ana = ana.Open("Session"), of_ben = ben.Open("Session");
  ASSERT_EQ(ana.Hello(*of_ana, "a"), absl::OkStatus());
  ASSERT_EQ(ben.Hello(*of_ben, "b"), absl::OkStatus());
  disk.Stall();
  // Half of it is hers, and half of the rest is his.
  const auto send_until_refused = [&](VisitorCall& session, uint64_t count) {
    for (uint64_t id = 1; id <= count; ++id) {
      commit.mutable_commit()->set_commit_id(id);
      session.Send(commit);
    }
    v1::SessionResponse response;
    EXPECT_TRUE(session.Read(response));
    EXPECT_EQ(response.commit_result().commit_id(), count);
    const absl::Status error = FromProto(response.commit_result().error());
    ExpectRefused(error, "QUOTA_PENDING_BYTES", "of one principal");
    EXPECT_TRUE(RetryDelayMs(error));
  };
  send_until_refused(*of_ana, 3);
  send_until_refused(*of_ben, 2);
  disk.Heal();
  v1::SessionResponse response;
  EXPECT_TRUE(of_ben->Read(response));
  EXPECT_EQ(response.commit_result().revision(), 1u) << "his first was let in";
  server_.Stop();  // before the disk that it writes to
}

// Computing that is used up is told, and told again when there is some; artifacts come all the
// same.
TEST_F(QuotaTest, C21WhoHasUsedUpTheirComputingIsToldAndKeepsGettingArtifacts) {
  ServerOptions options = server_.Options();
  options.quotas.each.compute_s_per_minute = 0.001;
  server_.Start(options);
  Visitor ana = Ana();
  ASSERT_EQ(ana.Create("s"), absl::OkStatus());
  const auto mesh = MeshOf(UnitBoxGeometry());
  ASSERT_EQ(ana.Upload(*mesh), absl::OkStatus());
  const auto session = ana.Open("Session");
  ASSERT_EQ(ana.Hello(*session, "s"), absl::OkStatus());
  SceneDelta delta = Studio(mesh);
  ASSERT_EQ(ana.Commit(*session, ToProto(delta)), absl::OkStatus());
  session->Send(SubscribeToFloor());
  bool is_told = false, is_there = false;
  v1::SessionResponse response;
  while (!(is_told && is_there) && session->Read(response)) {
    is_there = is_there || (response.artifact_update().has_header() &&
                            response.artifact_update().header().is_final());
    if (!response.has_compute_quota()) continue;
    is_told = true;
    const absl::Status error = FromProto(response.compute_quota().error());
    ExpectRefused(error, "QUOTA_COMPUTE", "need at most 0.001 a minute");
    EXPECT_GT(RetryDelayMs(error).value_or(0), 0);
  }
  EXPECT_TRUE(is_told);
  EXPECT_TRUE(is_there);
  // Over the quota, and still served where nobody else waits.
  delta = {.upsert_instances = delta.upsert_instances};
  delta.upsert_instances[0].world_from_mesh = Placed({0.3f, 1, 0}, 0.3f);
  v1::SessionRequest move;
  *move.mutable_commit()->mutable_delta() = ToProto(delta);
  session->Send(move);
  bool has_moved = false;
  while (!has_moved && session->Read(response)) {
    has_moved = response.artifact_update().revision() == 2;
  }
  EXPECT_TRUE(has_moved);
}

}  // namespace
}  // namespace penumbra::testing
