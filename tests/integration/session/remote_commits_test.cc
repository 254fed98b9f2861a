// Commits through a RemoteEngine, uploads, and the mirror of the scene.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "client/session/commit_in_parts.h"
#include "render/scene/field_error.h"
#include "tests/integration/session/remote_engine_fixture.h"

namespace penumbra::testing {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;

TEST_F(RemoteEngineTest, TheMirrorFollowsItsOwnAndOthersCommits) {
  const auto alice = Connect();
  const auto bob = Connect();
  ASSERT_EQ(alice->CreateScene("studio"), absl::OkStatus());
  ASSERT_EQ((*bob->Snapshot("studio"))->revision(), 0u);
  ASSERT_TRUE(alice->Commit("studio", Studio()).ok());

  // Bob hears of Alice's commit before the answer to his own that builds on it.
  SceneDelta ball;
  ball.upsert_lights = {{.id = "ball", .shape = SphereLight{.center = {0, 2, 0}}}};
  ASSERT_EQ(bob->Commit("studio", ball).value(), 2u);
  const auto of_bob = bob->Snapshot("studio");
  ASSERT_TRUE(of_bob.ok()) << of_bob.status();
  EXPECT_EQ((*of_bob)->revision(), 2u);
  ASSERT_NE((*of_bob)->FindInstance("box"), nullptr);
  EXPECT_EQ((*of_bob)->FindInstance("box")->mesh->triangle_count(), 12u);
  EXPECT_NE((*of_bob)->FindLight("ball"), nullptr);

  SceneDelta removal;
  removal.remove_lights = {"ball"};
  ASSERT_EQ(alice->Commit("studio", removal).value(), 3u);
  const auto of_alice = alice->Snapshot("studio");
  ASSERT_TRUE(of_alice.ok()) << of_alice.status();
  EXPECT_EQ((*of_alice)->revision(), 3u);
  EXPECT_EQ((*of_alice)->FindLight("ball"), nullptr);
  const auto infos = bob->ListScenes();
  ASSERT_TRUE(infos.ok());
  ASSERT_EQ(infos->size(), 1u);
  EXPECT_EQ((*infos)[0].content_hash, (*of_alice)->content_hash());
}

TEST_F(RemoteEngineTest, ALateClientMirrorsWhatIsThere) {
  const auto alice = Connect();
  ASSERT_EQ(alice->CreateScene("studio"), absl::OkStatus());
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(alice->Commit("studio", Studio(Vec3(0.1f * i, 0.5f, 0))).ok());
  }
  const auto bob = Connect();
  const auto of_bob = bob->Snapshot("studio");
  ASSERT_TRUE(of_bob.ok()) << of_bob.status();
  EXPECT_EQ((*of_bob)->revision(), 4u);
  EXPECT_EQ((*of_bob)->content_hash(), (*alice->Snapshot("studio"))->content_hash());
}

TEST_F(RemoteEngineTest, CommitsOfManyClientsAllArriveInEveryMirror) {
  constexpr int kClients = 4, kCommits = 20;
  const auto setup = Connect();
  ASSERT_EQ(setup->CreateScene("studio"), absl::OkStatus());
  std::vector<std::unique_ptr<RemoteEngine>> engines;
  for (int i = 0; i < kClients; ++i) engines.push_back(Connect());
  std::vector<std::future<absl::Status>> writers;
  for (int i = 0; i < kClients; ++i) {
    writers.push_back(std::async(std::launch::async, [&, i] {
      for (int n = 0; n < kCommits; ++n) {
        SceneDelta delta;
        delta.upsert_lights = {
            {.id = "light-" + std::to_string(i), .shape = PointLight{.position = Vec3(n, i, 1)}}};
        const auto revision = engines[i]->Commit("studio", delta);
        if (!revision.ok()) return revision.status();
        const auto scene = engines[i]->Snapshot("studio");
        if (!scene.ok()) return scene.status();
        if ((*scene)->revision() < *revision) return absl::InternalError("the mirror is behind");
      }
      return absl::OkStatus();
    }));
  }
  for (auto& writer : writers) EXPECT_EQ(writer.get(), absl::OkStatus());
  for (const auto& engine : engines) {
    // One commit more each makes sure that all before it have been heard of.
    const auto revision = engine->Commit("studio", {});
    ASSERT_TRUE(revision.ok());
  }
  const auto last = engines.back()->Snapshot("studio");
  ASSERT_TRUE(last.ok()) << last.status();
  EXPECT_EQ((*last)->revision(), static_cast<Revision>(kClients * (kCommits + 1)));
  EXPECT_EQ((*last)->lights().size(), static_cast<size_t>(kClients));
}

TEST_F(RemoteEngineTest, WhatTheServerHasIsNotSentAgain) {
  const auto alice = Connect();
  ASSERT_EQ(alice->CreateScene("studio"), absl::OkStatus());
  ASSERT_TRUE(alice->Commit("studio", Studio()).ok());
  EXPECT_EQ(alice->upload_traffic().blobs_sent, 1u);
  EXPECT_GT(alice->upload_traffic().bytes_sent, 8u * 12 + 36 * 4);
  ASSERT_TRUE(alice->Commit("studio", Studio(Vec3(1, 0.5f, 0))).ok());
  EXPECT_EQ(alice->upload_traffic().blobs_sent, 1u);
  const auto bob = Connect();
  ASSERT_EQ(bob->CreateScene("copy"), absl::OkStatus());
  ASSERT_TRUE(bob->Commit("copy", Studio()).ok());
  EXPECT_EQ(bob->upload_traffic().blobs_sent, 0u);
  EXPECT_EQ(bob->upload_traffic().blobs_known, 1u);
}

TEST_F(RemoteEngineTest, WhatNoCommitHoldsCanBeCommittedInParts) {
  const auto alice = Connect();
  const auto bob = Connect();
  ASSERT_EQ(alice->CreateScene("studio"), absl::OkStatus());
  EXPECT_EQ(CommitInParts(*alice, "studio", Studio()).value(), 1u) << "whole where that can be";
  const auto square = MeshOf(UnitSquareGeometry());
  const auto many = [&square](const std::string& stem) {
    SceneDelta delta;
    for (int i = 0; i < 20'000; ++i) {
      delta.upsert_instances.push_back({.id = stem + std::to_string(i), .mesh = square});
    }
    delta.upsert_receivers = {{.id = "r", .shape = PlanarInstance{stem + "19999"}}};
    return delta;
  };
  const SceneDelta first = many("a-tile-with-quite-a-name-");
  ASSERT_EQ(ErrorReason(alice->Commit("studio", first).status()), "QUOTA_MESSAGE");
  const auto revision = CommitInParts(*alice, "studio", first);
  ASSERT_TRUE(revision.ok()) << revision.status();
  EXPECT_GT(*revision, 2u);
  EXPECT_EQ((*alice->Snapshot("studio"))->instances().size(), 20'001u);

  // All of them go, and the receiver on the last to another.
  SceneDelta second = many("another-tile-with-quite-a-name-");
  for (const Instance& tile : first.upsert_instances) second.remove_instances.push_back(tile.id);
  second.base_revision = *revision;
  const auto replaced = CommitInParts(*alice, "studio", second);
  ASSERT_TRUE(replaced.ok()) << replaced.status();
  const auto scene =
      (*Scene::Empty("s")->Apply(Studio()))->Apply(many("another-tile-with-quite-a-name-"));
  EXPECT_EQ((*alice->Snapshot("studio"))->content_hash(), (*scene)->content_hash());
  EXPECT_EQ((*bob->Snapshot("studio"))->content_hash(), (*scene)->content_hash());
  EXPECT_EQ(ErrorReason(CommitInParts(*alice, "studio", second).status()), "STALE_BASE");
}

TEST_F(RemoteEngineTest, LargeMeshesTravelInPieces) {
  MeshGeometry grid;
  constexpr uint32_t kSide = 400;
  for (uint32_t j = 0; j < kSide; ++j) {
    for (uint32_t i = 0; i < kSide; ++i) grid.positions.emplace_back(i, (i * j) % 7, j);
  }
  for (uint32_t k = 0; k + kSide + 1 < kSide * kSide; ++k) {
    grid.indices.insert(grid.indices.end(), {k, k + 1, k + kSide});
  }
  const auto mesh = MeshOf(std::move(grid));  // 3.8 MB: more than one message holds
  const auto alice = Connect();
  ASSERT_EQ(alice->CreateScene("grid"), absl::OkStatus());
  SceneDelta delta;
  delta.upsert_instances = {{.id = "grid", .mesh = mesh}};
  const auto revision = alice->Commit("grid", delta);
  ASSERT_TRUE(revision.ok()) << revision.status();
  const auto bob = Connect();
  const auto scene = bob->Snapshot("grid");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ((*scene)->FindInstance("grid")->mesh->id(), mesh->id());
}

}  // namespace
}  // namespace penumbra::testing
