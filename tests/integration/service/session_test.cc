// The main job over a real connection: commits go in, artifacts come out.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "proto/convert/status_convert.h"
#include "render/engine/compute_once.h"
#include "render/engine/local_engine.h"
#include "render/scene/field_error.h"
#include "tests/integration/service/mirror.h"
#include "tests/integration/service/studio.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;

Artifact ComputedHere(const SceneDelta& delta, const ArtifactSpec& spec) {
  LocalEngine engine({.cpu_threads = 1});
  EXPECT_EQ(engine.CreateScene("studio"), absl::OkStatus());
  EXPECT_TRUE(engine.Commit("studio", delta).ok());
  return *ComputeOnce(engine, "studio", spec).value();
}

TEST_F(StudioTest, ArtifactIsTheOneThatThisProcessComputes) {
  for (const uint32_t samples : {16u, 300u}) {  // counts of one byte and of two
    ASSERT_EQ(session_->Subscribe(samples, FloorSpec(samples), 4), absl::OkStatus());
    const auto update = session_->AwaitUpdate(samples, IsFinal);
    const Artifact expected = ComputedHere(StudioDelta(), FloorSpec(samples));
    const auto& texture = std::get<SoftShadowTexture>(expected.payload);
    EXPECT_EQ(TextureOf(update).visibility.counts, texture.visibility.counts);
    EXPECT_EQ(TextureOf(update).visibility.sample_count, samples);
    EXPECT_EQ(TextureOf(update).receiver, texture.receiver);
    EXPECT_EQ(TextureOf(update).light, texture.light);
    EXPECT_EQ(update.artifact->header.light_samples, expected.header.light_samples);
    EXPECT_EQ(update.artifact->header.parameters, expected.header.parameters);
    EXPECT_EQ(update.artifact->header.scene_hash, expected.header.scene_hash);
    EXPECT_EQ(update.artifact->header.revision, 1u);
  }
}

TEST_F(StudioTest, RadianceTravelsToo) {
  ArtifactSpec spec = FloorSpec();
  std::get<SoftTextureParams>(spec.params).radiance = true;
  ASSERT_EQ(session_->Subscribe(1, spec, 4), absl::OkStatus());
  const auto update = session_->AwaitUpdate(1, IsFinal);
  const Artifact expected = ComputedHere(StudioDelta(), spec);
  ASSERT_TRUE(TextureOf(update).radiance.has_value());
  EXPECT_EQ(TextureOf(update).radiance->texels,
            std::get<SoftShadowTexture>(expected.payload).radiance->texels);
}

TEST_F(StudioTest, OnlyChangedTilesTravel) {
  session_->Commit(StudioDelta(1024));
  ASSERT_EQ(session_->Subscribe(1, FloorSpec(), 4), absl::OkStatus());
  session_->AwaitUpdate(1, FinalAt(2));
  const uint64_t tiles = session_->update_tiles();
  EXPECT_GE(tiles, 256u);
  session_->Commit(MoveBox({0.01f, 1, 0}));
  const auto update = session_->AwaitUpdate(1, FinalAt(3));
  // Around the shadow's edge, once a pass; the lit floor does not travel again.
  EXPECT_LT(session_->update_tiles() - tiles, 200u);
  SceneDelta all = StudioDelta(1024);
  all.upsert_instances = MoveBox({0.01f, 1, 0}).upsert_instances;
  EXPECT_EQ(TextureOf(update).visibility.counts,
            std::get<SoftShadowTexture>(ComputedHere(all, FloorSpec()).payload).visibility.counts);
}

TEST_F(StudioTest, ACommitThatChangesNoShadowCostsATinyMessage) {
  ASSERT_EQ(session_->Subscribe(1, FloorSpec(), 4), absl::OkStatus());
  const auto before = session_->AwaitUpdate(1, IsFinal);
  const uint64_t bytes = session_->update_bytes();
  session_->Commit(MoveBox({0, 1, 0}));  // to where it is
  const auto after = session_->AwaitUpdate(1, FinalAt(2));
  EXPECT_EQ(after.artifact, before.artifact);
  EXPECT_EQ(after.artifact->header.revision, 1u);
  EXPECT_LT(session_->update_bytes() - bytes, 32u);
}

TEST_F(StudioTest, AnUpdateLargerThanAMessageComesInSeveral) {
  ArtifactSpec spec = FloorSpec();
  std::get<SoftTextureParams>(spec.params).radiance = true;
  session_->Commit(StudioDelta(1000));  // 12 MB of radiance
  ASSERT_EQ(session_->Subscribe(1, spec, 4), absl::OkStatus());
  const auto update = session_->AwaitUpdate(1, FinalAt(2));
  EXPECT_GT(session_->update_messages(), 2u);
  const Artifact expected = ComputedHere(StudioDelta(1000), spec);
  EXPECT_EQ(TextureOf(update).radiance->texels,
            std::get<SoftShadowTexture>(expected.payload).radiance->texels);
}

TEST_F(StudioTest, TwoClientsReceiveTheSameBitsOfOneComputation) {
  WireClient other_client(server_->address());
  auto other = other_client.OpenSession("studio");
  ASSERT_EQ(session_->Subscribe(1, FloorSpec(), 64), absl::OkStatus());
  session_->AwaitUpdate(1, IsFinal);
  ASSERT_EQ(other->Subscribe(7, FloorSpec(), 64), absl::OkStatus());
  other->AwaitUpdate(7, IsFinal);
  const auto before = client_->ServerInfo().statistics();
  EXPECT_EQ(before.jobs_started(), 1u);

  session_->Commit(MoveBox({0.2f, 1, 0.1f}));
  const auto mine = session_->AwaitUpdate(1, FinalAt(2));
  const auto others = other->AwaitUpdate(7, FinalAt(2));
  EXPECT_EQ(TextureOf(mine).visibility.counts, TextureOf(others).visibility.counts);
  EXPECT_EQ(mine.artifact->header.light_samples, others.artifact->header.light_samples);
  EXPECT_EQ(mine.artifact->header.scene_hash, others.artifact->header.scene_hash);
  const auto after = client_->ServerInfo().statistics();
  EXPECT_EQ(after.jobs_started() - before.jobs_started(), 1u);
  EXPECT_LE(after.artifacts_encoded() - before.artifacts_encoded(),
            after.artifacts_computed() - before.artifacts_computed());
}

TEST_F(StudioTest, WithoutCreditNothingIsSentAndThenTheNewest) {
  ASSERT_EQ(session_->Subscribe(1, FloorSpec(), 0), absl::OkStatus());
  Revision revision = 1;
  for (int i = 1; i <= 20; ++i) {
    revision = session_->Commit(MoveBox({0.02f * static_cast<float>(i), 1, 0})).revision();
  }
  EXPECT_EQ(session_->update_messages(), 0u);
  session_->GrantCredit(1, 1);
  const auto update = session_->AwaitUpdate(1, FinalAt(revision));
  EXPECT_EQ(update.revision, 21u);
}

TEST_F(StudioTest, RemovingTheLightIsAnErrorThatTheNextCommitMends) {
  ASSERT_EQ(session_->Subscribe(1, FloorSpec(), 4), absl::OkStatus());
  const auto before = session_->AwaitUpdate(1, IsFinal);
  SceneDelta removal;
  removal.remove_lights = {"lamp"};
  session_->Commit(removal);
  const auto error =
      session_->AwaitUpdate(1, [](const auto& update) { return !update.status.ok(); });
  EXPECT_EQ(error.status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(error.status.message(), HasSubstr("lamp"));
  EXPECT_EQ(error.revision, 2u);
  SceneDelta again;
  again.upsert_lights = {SquareLight()};
  session_->Commit(again);
  const auto after = session_->AwaitUpdate(1, FinalAt(3));
  EXPECT_EQ(TextureOf(after).visibility.counts, TextureOf(before).visibility.counts);
}

TEST_F(StudioTest, UnsubscribingIsTheEndOfUpdates) {
  ASSERT_EQ(session_->Subscribe(1, FloorSpec(), 64), absl::OkStatus());
  session_->AwaitUpdate(1, IsFinal);
  v1::SessionRequest request;
  request.mutable_unsubscribe()->set_subscription_id(1);
  session_->Send(request);
  const auto ended = session_->ReadUntil(v1::SessionResponse::kSubscriptionEnded);
  EXPECT_FALSE(ended->subscription_ended().has_error());
  const uint64_t messages = session_->update_messages();
  session_->Commit(MoveBox({0.3f, 1, 0}));
  session_->Commit(MoveBox({0.2f, 1, 0}));
  EXPECT_EQ(session_->update_messages(), messages);
  EXPECT_EQ(client_->ServerInfo().statistics().open_subscriptions(), 0u);
  EXPECT_EQ(session_->Subscribe(1, FloorSpec(), 1), absl::OkStatus()) << "the id is free again";
}

TEST_F(StudioTest, DeletingTheSceneEndsItsSessions) {
  ASSERT_EQ(session_->Subscribe(1, FloorSpec(), 64), absl::OkStatus());
  session_->AwaitUpdate(1, IsFinal);
  ASSERT_EQ(client_->DeleteScene("studio"), absl::OkStatus());
  const auto ended = session_->ReadUntil(v1::SessionResponse::kSubscriptionEnded);
  EXPECT_EQ(FromProto(ended->subscription_ended().error()).code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(session_->End().code(), absl::StatusCode::kNotFound);
  session_ = std::make_unique<WireSession>(client_->stub());
  ASSERT_EQ(client_->CreateScene("studio"), absl::OkStatus());
  EXPECT_EQ(session_->Hello("studio").scene().revision(), 0u);
}

TEST_F(StudioTest, AMirrorFollowsTheCommitsOfOthers) {
  WireClient other_client(server_->address());
  auto other = other_client.OpenSession("studio", true);
  Mirror mirror;
  while (mirror.revision < 1) {
    mirror.Apply(other->ReadUntil(v1::SessionResponse::kSceneUpdate)->scene_update());
  }
  EXPECT_EQ(mirror.scene->instances().size(), 1u);
  SceneDelta delta;
  delta.upsert_instances = {Box({1, 1, 1}, "second")};
  delta.remove_lights = {"lamp"};
  session_->Commit(delta);
  mirror.Apply(other->ReadUntil(v1::SessionResponse::kSceneUpdate)->scene_update());
  EXPECT_EQ(mirror.revision, 2u);
  EXPECT_EQ(mirror.scene->content_hash(), client_->FindScene("studio")->content_hash);
  EXPECT_TRUE(mirror.scene->lights().empty());
  // Its own commit is not repeated to it.
  const auto result = other->Commit(MoveBox({0, 2, 0}));
  EXPECT_EQ(result.revision(), 3u);
  session_->Commit(MoveBox({0, 1, 0}));
  const auto update = other->ReadUntil(v1::SessionResponse::kSceneUpdate)->scene_update();
  EXPECT_EQ(update.from_revision(), 3u);
  EXPECT_EQ(update.revision(), 4u);
}

// Each update goes on where the one before has ended, and none is left out, however many there are.
TEST_F(StudioTest, AMirrorMissesNoneOfThousandsOfUpdates) {
  constexpr Revision kLast = 2'500;
  WireClient other_client(server_->address());
  auto other = other_client.OpenSession("studio", true);
  Mirror mirror;
  int updates = 0;
  for (Revision revision = 2; revision <= kLast && !HasFailure(); ++revision) {
    const float x = 1e-4f * static_cast<float>(revision);
    ASSERT_EQ(session_->Commit(MoveBox({x, 1, 0})).revision(), revision);
    // One behind, so that what is left out shows in what comes next.
    for (; mirror.revision + 1 < revision; ++updates) {
      const auto update = other->ReadUntil(v1::SessionResponse::kSceneUpdate);
      ASSERT_TRUE(update);
      mirror.Apply(update->scene_update());
    }
  }
  EXPECT_GT(updates, 1'000) << "hardly any have melted into others";
}

TEST_F(StudioTest, ALargeSceneIsMirroredInPieces) {
  SceneDelta many;
  for (int i = 0; i < 5000; ++i) {
    many.upsert_instances.push_back(Box({0, 1, 0}, "box" + std::to_string(i)));
  }
  ASSERT_EQ(session_->Commit(many).revision(), 2u);
  for (auto& instance : many.upsert_instances) instance.id += "_again";
  ASSERT_EQ(session_->Commit(many).revision(), 3u);
  WireClient other_client(server_->address());
  auto other = other_client.OpenSession("studio", true);
  Mirror mirror;
  int messages = 0;
  while (mirror.revision < 3) {
    mirror.Apply(other->ReadUntil(v1::SessionResponse::kSceneUpdate)->scene_update());
    ++messages;
  }
  EXPECT_GT(messages, 1);
  EXPECT_EQ(mirror.scene->content_hash(), client_->FindScene("studio")->content_hash);
}

}  // namespace
}  // namespace penumbra::testing
