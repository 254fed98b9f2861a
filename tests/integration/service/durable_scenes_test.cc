// Scenes that outlive their server.

#include "tests/integration/service/durable_scenes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

#include "render/scene/field_error.h"

namespace penumbra::testing {
namespace {

namespace fs = std::filesystem;

TEST_F(DurableScenesTest, AreBackAsTheyWere) {
  Restart();
  MakeStudio();
  for (int i = 0; i < 5; ++i) ASSERT_FALSE(session_->Commit(MoveBox({0, 1, 0.1f * i})).has_error());
  ASSERT_EQ(client_->CreateScene("empty"), absl::OkStatus());
  const SceneInfo before = client_->FindScene("studio").value();
  Restart();
  const SceneInfo after = client_->FindScene("studio").value();
  EXPECT_EQ(after.revision, 6u);
  EXPECT_EQ(after.content_hash, before.content_hash);
  EXPECT_EQ(client_->FindScene("empty")->revision, 0u);
  // With its meshes, and ready for more.
  session_ = client_->OpenSession("studio");
  EXPECT_EQ(session_->Commit(MoveBox({0, 1, 1})).revision(), 7u);
  ASSERT_EQ(session_->Subscribe(1, FloorSpec(), 8), absl::OkStatus());
  EXPECT_TRUE(session_->AwaitUpdate(1, FinalAt(7)).artifact);
}

TEST_F(DurableScenesTest, B08AnAnswerIsRememberedAcrossRestarts) {
  Restart();
  MakeStudio();
  const auto first = session_->Commit(MoveBox({1, 1, 0}), "key-1");
  ASSERT_EQ(session_->Commit(MoveBox({2, 1, 0})).revision(), 3u);
  Restart();
  session_ = client_->OpenSession("studio");
  const auto again = session_->Commit(MoveBox({1, 1, 0}), "key-1");
  EXPECT_EQ(again.revision(), first.revision());
  EXPECT_EQ(again.content_hash(), first.content_hash());
  EXPECT_EQ(client_->FindScene("studio")->revision, 3u) << "applied once";
  EXPECT_EQ(ErrorReason(ErrorIn(session_->Commit(MoveBox({3, 1, 0}), "key-1"))),
            "REQUEST_ID_REUSED");
}

TEST_F(DurableScenesTest, ADeletionLastsAndTheIdIsFree) {
  Restart();
  MakeStudio();
  ASSERT_EQ(client_->DeleteScene("studio"), absl::OkStatus());
  EXPECT_TRUE(fs::is_empty(folder_ / "data/scenes"));
  Restart();
  EXPECT_TRUE(client_->ListScenes()->empty());
  ASSERT_EQ(client_->CreateScene("studio"), absl::OkStatus());
  EXPECT_EQ(client_->FindScene("studio")->revision, 0u);
}

TEST_F(DurableScenesTest, DeletionsAndCreationsAtOnceLoseNothing) {
  Restart();
  ASSERT_EQ(client_->Upload(*BoxMesh()), absl::OkStatus());
  std::atomic<bool> is_over = false;
  std::vector<std::thread> others;
  for (int i = 0; i < 3; ++i) {
    others.emplace_back([&] {
      WireClient client(server_->address());
      while (!is_over) {
        client.CreateScene("studio").IgnoreError();
        client.DeleteScene("studio").IgnoreError();
      }
    });
  }
  std::this_thread::sleep_for(std::chrono::seconds(1));
  is_over = true;
  for (std::thread& other : others) other.join();
  client_->DeleteScene("studio").IgnoreError();
  MakeStudio();
  const SceneInfo before = client_->FindScene("studio").value();
  Restart();
  EXPECT_EQ(client_->FindScene("studio")->content_hash, before.content_hash);
  EXPECT_EQ(client_->ListScenes()->size(), 1u);
}

TEST_F(DurableScenesTest, BlobsThatNothingNeedsAreCollected) {
  options_.storage.history = {.commits = 2, .snapshot_after_bytes = 100, .answers = 8};
  options_.storage.house_interval = std::chrono::seconds(1);
  options_.limits.unused_blob_lifetime = std::chrono::seconds(0);
  Restart();
  MakeStudio();
  const auto count_blobs = [this] {
    size_t count = 0;
    for (const auto& file : fs::recursive_directory_iterator(folder_ / "data/blobs")) {
      count += file.is_regular_file();
    }
    return count;
  };
  EXPECT_EQ(count_blobs(), 1u);
  std::this_thread::sleep_for(std::chrono::milliseconds(2'500));
  EXPECT_EQ(count_blobs(), 1u) << "it is in use";
  SceneDelta remove;
  remove.remove_instances = {"box"};
  ASSERT_FALSE(session_->Commit(remove).has_error());
  for (int i = 0; i < 8; ++i) ASSERT_FALSE(session_->Commit(SceneDelta()).has_error());
  for (int i = 0; i < 100 && count_blobs() > 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  EXPECT_EQ(count_blobs(), 0u) << "neither the scene nor its history mentions it";
}

TEST_F(DurableScenesTest, D04ADamagedSceneIsRefusedAndTheOthersAreServed) {
  Restart();
  MakeStudio("good");
  MakeStudio("bad");
  server_.reset();
  const std::string file = SceneFileOf("bad");
  std::ifstream stream(file, std::ios::binary);
  std::string damaged((std::istreambuf_iterator<char>(stream)), {});
  const size_t lamp = damaged.find("lamp");
  ASSERT_NE(lamp, std::string::npos);
  damaged[lamp] = 'd';
  std::ofstream(file, std::ios::binary) << damaged;
  Restart();
  EXPECT_EQ(logger_.Await("scene_refused", 1)[0]["scene"], "bad");
  EXPECT_EQ(client_->FindScene("good")->revision, 1u);
  EXPECT_EQ(EndOfSession("bad").code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(client_->CreateScene("bad").code(), absl::StatusCode::kAlreadyExists);
  server_.reset();
  std::ifstream again(file, std::ios::binary);
  EXPECT_EQ(std::string((std::istreambuf_iterator<char>(again)), {}), damaged) << "left as it is";
  // Who deletes it has it aside.
  Restart();
  EXPECT_EQ(client_->DeleteScene("bad"), absl::OkStatus());
  EXPECT_EQ(client_->CreateScene("bad"), absl::OkStatus());
  EXPECT_FALSE(fs::is_empty(folder_ / "data/removed"));
}

TEST_F(DurableScenesTest, D03WhatHeadsKnowOfIsMissed) {
  Restart();
  MakeStudio();
  ASSERT_EQ(client_->CreateScene("gone"), absl::OkStatus());
  server_.reset();
  // Yesterday's file in place of today's, and one that is not there at all.
  const std::string kept = folder_ / "kept.db";
  fs::copy_file(SceneFileOf("studio"), kept);
  Restart();
  session_ = client_->OpenSession("studio");
  ASSERT_EQ(session_->Commit(MoveBox({1, 1, 1})).revision(), 2u);
  session_.reset();
  server_.reset();
  fs::copy_file(kept, SceneFileOf("studio"), fs::copy_options::overwrite_existing);
  fs::remove(SceneFileOf("gone"));
  Restart();
  const auto refused = logger_.Await("scene_refused", 2);
  EXPECT_EQ(refused[0]["scene"], "studio");
  EXPECT_EQ(refused[1]["scene"], "gone");
  EXPECT_EQ(EndOfSession("studio").code(), absl::StatusCode::kDataLoss);
}

TEST_F(DurableScenesTest, D08ASecondServerIsRefused) {
  Restart();
  ServerOptions second = options_;
  second.listen = "127.0.0.1:0";
  second.opens_gl = false;
  const auto refused = PenumbraServer::Start(second);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(ErrorReason(refused.status()), "DATA_DIR_LOCKED");
}

}  // namespace
}  // namespace penumbra::testing
