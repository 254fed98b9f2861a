// The studio with a second client in it, who must notice nothing of what the first does wrong.
//
//   TEST_F(CatalogueTest, B01ScenesWithoutAName) {
//     ExpectRefused([&] { return client_->CreateScene(""); },
//                   {absl::StatusCode::kInvalidArgument, "BAD_ID", "scene_id"});
//   }
//
// After each refusal the connection that it came over is asked for the scene, which must be at the
// revision and of the hash that it was, and for the blobs, of which there must be as many. At the
// end of each test the refused session commits once more; the second client, on a connection of its
// own, has until then heard of what was accepted, step by step, and gets the shadow of the last.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "gtest/gtest.h"
#include "proto/convert/status_convert.h"
#include "render/scene/field_error.h"
#include "tests/integration/service/mirror.h"
#include "tests/integration/service/studio.h"

namespace penumbra::testing {

// As a client reads it: the reason and the field are those of google.rpc.ErrorInfo.
struct Refusal {
  absl::StatusCode code;
  std::string reason;
  std::string field;
};

class CatalogueTest : public StudioTest {
 protected:
  void SetUp() override {
    StudioTest::SetUp();
    bystander_client_ = std::make_unique<WireClient>(server_->address());
    bystander_ = bystander_client_->OpenSession("studio", /*mirror_scene=*/true);
    const auto snapshot = bystander_->ReadUntil(v1::SessionResponse::kSceneUpdate);
    ASSERT_TRUE(snapshot);
    mirror_.Apply(snapshot->scene_update());
    ASSERT_EQ(bystander_->Subscribe(1, FloorSpec(), 64), absl::OkStatus());
    bystander_->AwaitUpdate(1, IsFinal);
  }
  void TearDown() override {
    if (!HasFatalFailure()) ExpectUndisturbed();
  }

  void ExpectRefused(const std::function<absl::Status()>& ask, const Refusal& expected) {
    const SceneInfo before = client_->FindScene("studio").value();
    const auto blobs_before = client_->ServerInfo().statistics();
    const absl::Status status = ask();
    EXPECT_EQ(status.code(), expected.code) << status;
    EXPECT_EQ(ErrorReason(status), expected.reason) << status;
    EXPECT_EQ(ErrorFieldPath(status), expected.field) << status;
    const SceneInfo after = client_->FindScene("studio").value();
    EXPECT_EQ(after.revision, before.revision) << status;
    EXPECT_EQ(after.content_hash, before.content_hash) << status;
    const auto blobs_after = client_->ServerInfo().statistics();
    EXPECT_EQ(blobs_after.blobs(), blobs_before.blobs()) << status;
    EXPECT_EQ(blobs_after.blob_bytes(), blobs_before.blob_bytes()) << status;
  }
  // Of a delta; its answer names the revision and hash that the scene still has.
  void ExpectRefused(const v1::SceneDelta& delta, const Refusal& expected) {
    const SceneInfo before = client_->FindScene("studio").value();
    v1::CommitResult result;
    ExpectRefused(
        [&] {
          result = session_->Commit(delta);
          return FromProto(result.error());
        },
        expected);
    EXPECT_EQ(result.revision(), before.revision);
    EXPECT_EQ(result.content_hash(), ToProto(before.content_hash));
  }

  // What the session is sent of the floor, once all that was committed until then counts.
  SoftShadowTexture FloorAt(Revision revision) {
    if (!std::exchange(follows_floor_, true)) {
      EXPECT_EQ(session_->Subscribe(kFloor, FloorSpec(), 4), absl::OkStatus());
    }
    const ArtifactUpdate update = session_->AwaitUpdate(kFloor, FinalAt(revision));
    return update.artifact ? TextureOf(update) : SoftShadowTexture();
  }

  void ExpectUndisturbed() {
    const SceneInfo before = client_->FindScene("studio").value();
    const auto next = session_->Commit(MoveBox({0.1f, 1, 0.05f}));
    ASSERT_FALSE(next.has_error()) << next.error().message();
    EXPECT_EQ(next.revision(), before.revision + 1);
    while (mirror_.revision < next.revision()) {
      const auto update = bystander_->ReadUntil(v1::SessionResponse::kSceneUpdate);
      ASSERT_TRUE(update);
      mirror_.Apply(update->scene_update());
    }
    EXPECT_EQ(mirror_.revision, next.revision());
    EXPECT_EQ(ToProto(mirror_.scene->content_hash()), next.content_hash());
    EXPECT_TRUE(bystander_->AwaitUpdate(1, FinalAt(next.revision())).artifact);
  }

  std::unique_ptr<WireClient> bystander_client_;
  std::unique_ptr<WireSession> bystander_;
  Mirror mirror_;  // the bystander's

 private:
  static constexpr uint64_t kFloor = 1'000;
  bool follows_floor_ = false;
};

}  // namespace penumbra::testing
