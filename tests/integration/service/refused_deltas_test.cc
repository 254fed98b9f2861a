// What bad deltas get: the right code, a stable reason and the field; the scene as it was, other
// clients undisturbed, and the session still good.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <thread>

#include "proto/convert/geometry_convert.h"
#include "proto/convert/light_convert.h"
#include "proto/convert/scene_convert.h"
#include "proto/convert/status_convert.h"
#include "render/scene/blob.h"
#include "render/scene/field_error.h"
#include "tests/integration/service/studio.h"

namespace penumbra::testing {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

v1::Instance AnotherBox() { return ToProto(Box({1, 1, 1}, "another")); }

struct RefusedDelta {
  const char* name;
  std::function<void(v1::SceneDelta&)> write;
  absl::StatusCode code;
  const char* reason;
  const char* field;
};

const RefusedDelta kRefusedDeltas[] = {
    {"NanInTransform",
     [](v1::SceneDelta& delta) {
       *delta.add_upsert_instances() = AnotherBox();
       delta.mutable_upsert_instances(0)->set_world_from_mesh(9, kNan);
     },
     absl::StatusCode::kInvalidArgument, "NON_FINITE", "upsert_instances[0].world_from_mesh"},
    {"InfiniteLight",
     [](v1::SceneDelta& delta) {
       *delta.add_upsert_lights() = ToProto(SquareLight());
       delta.mutable_upsert_lights(0)->mutable_rectangle()->mutable_corner()->set_y(kInfinity);
     },
     absl::StatusCode::kInvalidArgument, "NON_FINITE", "upsert_lights[0].corner"},
    {"FarAway",
     [](v1::SceneDelta& delta) {
       *delta.add_upsert_instances() = AnotherBox();
       delta.mutable_upsert_instances(0)->set_world_from_mesh(9, 1e16f);
     },
     absl::StatusCode::kInvalidArgument, "OUT_OF_BOUNDS", "upsert_instances[0].world_from_mesh"},
    {"ElevenNumbers",
     [](v1::SceneDelta& delta) {
       *delta.add_upsert_instances() = AnotherBox();
       delta.mutable_upsert_instances(0)->mutable_world_from_mesh()->RemoveLast();
     },
     absl::StatusCode::kInvalidArgument, "LENGTH", "upsert_instances[0].world_from_mesh"},
    {"LightOfNoArea",
     [](v1::SceneDelta& delta) {
       auto& light = *delta.add_upsert_lights();
       light.set_id("lamp");
       light.mutable_rectangle()->mutable_edge_u();  // (0, 0, 0)
     },
     absl::StatusCode::kInvalidArgument, "ZERO_AREA", "upsert_lights[0].edge_u"},
    {"RadiusZero",
     [](v1::SceneDelta& delta) {
       auto& light = *delta.add_upsert_lights();
       light.set_id("lamp");
       light.mutable_sphere()->set_radius(0);
     },
     absl::StatusCode::kInvalidArgument, "ZERO_AREA", "upsert_lights[0].radius"},
    {"LightWithoutShape", [](v1::SceneDelta& delta) { delta.add_upsert_lights()->set_id("lamp"); },
     absl::StatusCode::kInvalidArgument, "MISSING_FIELD", "upsert_lights[0].shape"},
    {"ReceiverOfNoArea",
     [](v1::SceneDelta& delta) {
       auto& receiver = *delta.add_upsert_receivers();
       receiver.set_id("floor");
       receiver.mutable_parallelogram()->mutable_edge_v()->set_x(2);  // along edge_u
     },
     absl::StatusCode::kInvalidArgument, "ZERO_AREA", "upsert_receivers[0].edge_v"},
    {"ReceiverTooWide",
     [](v1::SceneDelta& delta) {
       auto& receiver = *delta.add_upsert_receivers();
       receiver.set_id("floor");
       receiver.mutable_parallelogram();
       receiver.set_width(0x80000000u);
     },
     absl::StatusCode::kInvalidArgument, "RANGE", "upsert_receivers[0].width"},
    {"EmptyId",
     [](v1::SceneDelta& delta) {
       *delta.add_upsert_instances() = AnotherBox();
       delta.mutable_upsert_instances(0)->clear_id();
     },
     absl::StatusCode::kInvalidArgument, "BAD_ID", "upsert_instances[0].id"},
    {"IdWithAPath",
     [](v1::SceneDelta& delta) {
       *delta.add_upsert_instances() = AnotherBox();
       delta.mutable_upsert_instances(0)->set_id("../../etc/passwd");
     },
     absl::StatusCode::kInvalidArgument, "BAD_ID", "upsert_instances[0].id"},
    {"LongId",
     [](v1::SceneDelta& delta) {
       *delta.add_upsert_instances() = AnotherBox();
       delta.mutable_upsert_instances(0)->set_id(std::string(500'000, 'a'));
     },
     absl::StatusCode::kInvalidArgument, "BAD_ID", "upsert_instances[0].id"},
    {"SameIdTwice",
     [](v1::SceneDelta& delta) {
       *delta.add_upsert_instances() = AnotherBox();
       *delta.add_upsert_instances() = AnotherBox();
     },
     absl::StatusCode::kInvalidArgument, "DUPLICATE_ID", "upsert_instances[1].id"},
    {"UnknownRemoval", [](v1::SceneDelta& delta) { delta.add_remove_instances("ghost"); },
     absl::StatusCode::kNotFound, "UNKNOWN_ID", "remove_instances[0]"},
    {"MissingMesh",
     [](v1::SceneDelta& delta) {
       *delta.add_upsert_instances() = AnotherBox();
       delta.mutable_upsert_instances(0)->set_mesh_hash(std::string(32, 'x'));
     },
     absl::StatusCode::kFailedPrecondition, "MISSING_BLOB", "upsert_instances[0].mesh_hash"},
    {"ShortHash",
     [](v1::SceneDelta& delta) {
       *delta.add_upsert_instances() = AnotherBox();
       delta.mutable_upsert_instances(0)->set_mesh_hash("short");
     },
     absl::StatusCode::kInvalidArgument, "LENGTH", "upsert_instances[0].mesh_hash"},
    {"ReceiverOnAMissingInstance",
     [](v1::SceneDelta& delta) {
       auto& receiver = *delta.add_upsert_receivers();
       receiver.set_id("wall");
       receiver.mutable_planar_instance()->set_instance_id("ghost");
     },
     absl::StatusCode::kFailedPrecondition, "MISSING_INSTANCE", "upsert_receivers[0].instance_id"},
    {"StaleBase", [](v1::SceneDelta& delta) { delta.set_base_revision(0); },
     absl::StatusCode::kAborted, "STALE_BASE", "base_revision"},
    {"FutureBase",
     [](v1::SceneDelta& delta) { delta.set_base_revision(std::numeric_limits<int64_t>::max()); },
     absl::StatusCode::kOutOfRange, "FUTURE_BASE", "base_revision"},
    {"GoodFirstBadLast",
     [](v1::SceneDelta& delta) {
       *delta.add_upsert_instances() = AnotherBox();
       delta.add_remove_lights("lamp");
       delta.add_remove_receivers("ghost");
     },
     absl::StatusCode::kNotFound, "UNKNOWN_ID", "remove_receivers[0]"},
};

class RefusedDeltaTest : public StudioTest, public ::testing::WithParamInterface<RefusedDelta> {};

TEST_P(RefusedDeltaTest, LeavesEverythingAsItWas) {
  WireClient bystander_client(server_->address());
  auto bystander = bystander_client.OpenSession("studio", true);
  bystander->ReadUntil(v1::SessionResponse::kSceneUpdate);  // the snapshot
  ASSERT_EQ(bystander->Subscribe(1, FloorSpec(), 64), absl::OkStatus());
  bystander->AwaitUpdate(1, IsFinal);
  const SceneInfo before = client_->FindScene("studio").value();

  v1::SceneDelta delta;
  GetParam().write(delta);
  const auto result = session_->Commit(delta);
  const absl::Status status = FromProto(result.error());
  EXPECT_EQ(status.code(), GetParam().code) << status;
  EXPECT_EQ(ErrorReason(status), GetParam().reason) << status;
  EXPECT_EQ(ErrorFieldPath(status), GetParam().field) << status;
  EXPECT_EQ(result.revision(), before.revision);
  EXPECT_EQ(result.content_hash(), ToProto(before.content_hash));
  const SceneInfo after = client_->FindScene("studio").value();
  EXPECT_EQ(after.revision, before.revision);
  EXPECT_EQ(after.content_hash, before.content_hash);

  const auto next = session_->Commit(MoveBox({0.1f, 1, 0}));
  EXPECT_FALSE(next.has_error()) << next.error().message();
  EXPECT_EQ(next.revision(), before.revision + 1);
  // The first that the bystander hears of since.
  const auto heard = bystander->ReadUntil(v1::SessionResponse::kSceneUpdate)->scene_update();
  EXPECT_EQ(heard.from_revision(), before.revision);
  EXPECT_EQ(heard.revision(), before.revision + 1);
  EXPECT_EQ(bystander->AwaitUpdate(1, IsFinal).revision, before.revision + 1);
}

INSTANTIATE_TEST_SUITE_P(All, RefusedDeltaTest, ::testing::ValuesIn(kRefusedDeltas),
                         [](const auto& row) { return row.param.name; });

TEST_F(StudioTest, WhatIsOddButMeaningfulIsAccepted) {
  SceneDelta odd;
  odd.upsert_instances = {Box({0, 1, 0}, "flat"), Box({0, 1, 0}, "mirrored"),
                          Box({-0.0f, 1e-40f, 0}, "denormal")};
  odd.upsert_instances[0].world_from_mesh = Placed({0, 1, 0}, 0.0f);
  odd.upsert_instances[1].world_from_mesh = Placed({0, 1, 0}, -0.3f);
  odd.upsert_lights = {SquareLight(0.0f)};  // in the receiver's plane
  EXPECT_EQ(session_->Commit(odd).revision(), 2u);
  ASSERT_EQ(session_->Subscribe(1, FloorSpec(), 4), absl::OkStatus());
  EXPECT_TRUE(session_->AwaitUpdate(1, FinalAt(2)).status.ok());
}

TEST_F(StudioTest, ARepeatedCommitIsAppliedOnce) {
  const auto first = session_->Commit(MoveBox({1, 1, 1}), "key-1");
  session_->Commit(MoveBox({2, 1, 1}));
  auto reconnected = client_->OpenSession("studio");
  const auto again = reconnected->Commit(MoveBox({1, 1, 1}), "key-1");
  EXPECT_EQ(again.revision(), first.revision());
  EXPECT_EQ(again.content_hash(), first.content_hash());
  EXPECT_EQ(client_->FindScene("studio")->revision, 3u);
  const absl::Status other = FromProto(session_->Commit(MoveBox({3, 1, 1}), "key-1").error());
  EXPECT_EQ(other.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ErrorReason(other), "REQUEST_ID_REUSED");
  EXPECT_EQ(client_->FindScene("studio")->revision, 3u);
}

TEST(RepeatedCommitTest, GetsItsAnswerAfterItsMeshesAreGone) {
  ServerOptions options;
  options.limits.unused_blob_lifetime = std::chrono::seconds(0);
  options.limits.max_blob_store_bytes = EncodeBlob(BoxMesh()->geometry()).size() + 100;
  const auto server = StartServer(options);
  WireClient client(server->address());
  ASSERT_EQ(client.CreateScene("studio"), absl::OkStatus());
  ASSERT_EQ(client.Upload(*BoxMesh()), absl::OkStatus());
  auto session = client.OpenSession("studio");
  const auto first = session->Commit(StudioDelta(), "key");
  ASSERT_EQ(first.revision(), 1u);
  SceneDelta removal;
  removal.remove_instances = {"box"};
  ASSERT_EQ(session->Commit(removal).revision(), 2u);
  std::this_thread::sleep_for(std::chrono::milliseconds(10));
  ASSERT_EQ(client.Upload(*MeshOf(UnitSquareGeometry())), absl::OkStatus());
  ASSERT_EQ(client.FindMissing({ToProto(BoxMesh()->id())})->size(), 1u) << "it had to make room";

  const auto again = session->Commit(StudioDelta(), "key");
  EXPECT_FALSE(again.has_error()) << again.error().message();
  EXPECT_EQ(again.revision(), 1u);
  EXPECT_EQ(again.content_hash(), first.content_hash());
  const absl::Status other = FromProto(session->Commit(StudioDelta(64), "key").error());
  EXPECT_EQ(ErrorReason(other), "REQUEST_ID_REUSED");
  const absl::Status fresh = FromProto(session->Commit(StudioDelta(), "another-key").error());
  EXPECT_EQ(ErrorReason(fresh), "MISSING_BLOB");
}

TEST_F(StudioTest, OfWritersOnOneBaseOneWins) {
  auto other = client_->OpenSession("studio");
  SceneDelta mine = MoveBox({1, 1, 0});
  SceneDelta theirs = MoveBox({-1, 1, 0});
  mine.base_revision = theirs.base_revision = 1;
  EXPECT_EQ(session_->Commit(mine).revision(), 2u);
  const auto refused = other->Commit(theirs);
  EXPECT_EQ(FromProto(refused.error()).code(), absl::StatusCode::kAborted);
  EXPECT_EQ(refused.revision(), 2u) << "the head, to try again on";
  theirs.base_revision = refused.revision();
  EXPECT_EQ(other->Commit(theirs).revision(), 3u);
}

}  // namespace
}  // namespace penumbra::testing
