// Scenes that outlive their server: told to end, killed, and on a disk that fails.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <random>
#include <thread>

#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "proto/convert/status_convert.h"
#include "render/scene/field_error.h"
#include "tests/integration/service/daemon.h"
#include "tests/integration/service/studio.h"
#include "tests/support/event_log.h"
#include "tests/support/faulty_vfs.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

absl::Status ErrorIn(const v1::CommitResult& result) { return FromProto(result.error()); }

class DurableScenesTest : public ::testing::Test {
 protected:
  // Ends the server that is there, if any, and starts one on the same folder.
  void Restart() {
    session_.reset();
    client_.reset();
    server_.reset();
    options_.data_dir = folder_ / "data";
    options_.logger = &logger_;
    server_ = StartServer(options_);
    client_ = std::make_unique<WireClient>(server_->address());
  }
  void MakeStudio(const std::string& id = "studio") {
    ASSERT_EQ(client_->CreateScene(id), absl::OkStatus());
    ASSERT_EQ(client_->Upload(*BoxMesh()), absl::OkStatus());
    session_ = client_->OpenSession(id);
    ASSERT_EQ(session_->Commit(StudioDelta()).revision(), 1u);
  }
  // Of one that the server refuses.
  absl::Status EndOfSession(const std::string& scene_id) {
    WireSession session(client_->stub());
    v1::SessionRequest request;
    request.mutable_hello()->add_protocol_versions(1);
    request.mutable_hello()->set_scene_id(scene_id);
    session.Send(request);
    return session.End();
  }
  std::string SceneFileOf(const std::string& id) {
    return folder_ / ("data/scenes/" + id + "~1.db");
  }
  TemporaryFolder folder_;
  ServerOptions options_;
  EventLog logger_;
  std::unique_ptr<PenumbraServer> server_;
  std::unique_ptr<WireClient> client_;
  std::unique_ptr<WireSession> session_;
};

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
  EXPECT_THAT(logger_.text(), HasSubstr("scene_refused scene=bad"));
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
  EXPECT_THAT(logger_.text(), HasSubstr("scene_refused scene=studio"));
  EXPECT_THAT(logger_.text(), HasSubstr("scene_refused scene=gone"));
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

TEST_F(DurableScenesTest, D05AFullDiskAcknowledgesNothingAndReadsGoOn) {
  FaultyVfs disk;
  options_.storage.database.vfs = disk.name();
  Restart();
  MakeStudio();
  ASSERT_EQ(session_->Subscribe(1, FloorSpec(), 1'000), absl::OkStatus());
  session_->AwaitUpdate(1, FinalAt(1));
  disk.FailAfter(0, FaultyVfs::Call::kWrite, SQLITE_FULL);
  const auto full = session_->Commit(MoveBox({1, 1, 0}), "while-full");
  EXPECT_EQ(ErrorIn(full).code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ErrorReason(ErrorIn(full)), "DISK_FULL");
  EXPECT_EQ(full.revision(), 1u) << "the scene is as it was";
  ASSERT_EQ(session_->Subscribe(2, FloorSpec(4), 8), absl::OkStatus());
  EXPECT_TRUE(session_->AwaitUpdate(2, FinalAt(1)).artifact);
  disk.Heal();
  EXPECT_EQ(session_->Commit(MoveBox({1, 1, 0}), "while-full").revision(), 2u);
  options_.storage.database.vfs = nullptr;
  Restart();
  EXPECT_EQ(client_->FindScene("studio")->revision, 2u);
}

TEST_F(DurableScenesTest, D06AfterAFailedSyncAFileIsBegunAnew) {
  FaultyVfs disk;
  options_.storage.database.vfs = disk.name();
  Restart();
  MakeStudio();
  ASSERT_EQ(session_->Commit(MoveBox({1, 1, 0}), "before").revision(), 2u);
  disk.FailAfter(0, FaultyVfs::Call::kSync, SQLITE_IOERR_FSYNC);
  for (int i = 0; i < 3; ++i) {
    const auto failed = session_->Commit(MoveBox({2, 1, 0}));
    EXPECT_EQ(ErrorIn(failed).code(), absl::StatusCode::kUnavailable);
    EXPECT_EQ(failed.revision(), 2u);
  }
  const SceneInfo acknowledged = client_->FindScene("studio").value();
  disk.Heal();
  const auto healed = session_->Commit(MoveBox({3, 1, 0}), "after");
  EXPECT_EQ(healed.revision(), 3u) << ErrorIn(healed);
  EXPECT_TRUE(fs::exists(folder_ / "data/scenes/studio~2.db"));
  EXPECT_FALSE(fs::exists(folder_ / "data/scenes/studio~1.db"));
  options_.storage.database.vfs = nullptr;
  Restart();
  EXPECT_EQ(client_->FindScene("studio")->revision, 3u);
  session_ = client_->OpenSession("studio");
  EXPECT_EQ(session_->Commit(MoveBox({1, 1, 0}), "before").revision(), 2u) << "answers go along";
  EXPECT_EQ(session_->Commit(MoveBox({3, 1, 0}), "after").content_hash(), healed.content_hash());
  EXPECT_GT(healed.revision(), acknowledged.revision);
}

TEST_F(DurableScenesTest, CompactedScenesAreBackToo) {
  options_.storage.history = {.commits = 10, .snapshot_after_bytes = 2'000, .answers = 8};
  Restart();
  MakeStudio();
  for (int i = 0; i < 60; ++i) {
    ASSERT_FALSE(
        session_->Commit(MoveBox({0, 1, 0.01f * i}), "key" + std::to_string(i)).has_error());
  }
  const SceneInfo before = client_->FindScene("studio").value();
  Restart();
  EXPECT_EQ(client_->FindScene("studio")->revision, before.revision);
  EXPECT_EQ(client_->FindScene("studio")->content_hash, before.content_hash);
  session_ = client_->OpenSession("studio");
  EXPECT_EQ(session_->Commit(MoveBox({0, 1, 0.01f * 59}), "key59").revision(), before.revision);
}

// Commits until there is no answer; the newest answer, if there is any.
std::optional<v1::CommitResult> CommitUntilTheEnd(WireSession& session, float z) {
  std::optional<v1::CommitResult> newest;
  for (int i = 0;; ++i) {
    v1::SessionRequest request;
    *request.mutable_commit()->mutable_delta() = ToProto(MoveBox({0.001f * i, 1, z}));
    session.Send(request);
    const auto response = session.Read();
    if (!response) return newest;
    EXPECT_FALSE(response->commit_result().has_error());
    newest = response->commit_result();
  }
}

// Row D01.
TEST(KilledDaemonTest, D01EveryAcknowledgedCommitIsThere) {
  const TemporaryFolder folder;
  std::mt19937 random(3);
  Revision acknowledged = 0;
  std::string hash;
  for (int life = 0; life < 6; ++life) {
    Daemon daemon({"--listen", "127.0.0.1:0", "--data-dir", folder / "data"});
    WireClient client(daemon.Address());
    if (life == 0) {
      ASSERT_EQ(client.CreateScene("studio"), absl::OkStatus());
      ASSERT_EQ(client.Upload(*BoxMesh()), absl::OkStatus());
    }
    const SceneInfo found = client.FindScene("studio").value();
    ASSERT_GE(found.revision, acknowledged);
    ASSERT_LE(found.revision, acknowledged + 1) << "one may have been on its way";
    if (found.revision == acknowledged && life > 0) {
      EXPECT_EQ(ToProto(found.content_hash), hash);
    }
    auto session = client.OpenSession("studio");
    if (life == 0) {
      ASSERT_EQ(session->Commit(StudioDelta()).revision(), 1u);
    }
    std::thread killer([&, after = std::chrono::milliseconds(20 + random() % 100)] {
      std::this_thread::sleep_for(after);
      daemon.Signal(SIGKILL);
    });
    if (const auto newest = CommitUntilTheEnd(*session, 0.1f * life)) {
      acknowledged = newest->revision();
      hash = newest->content_hash();
    }
    killer.join();
  }
  EXPECT_GT(acknowledged, 20u);
}

}  // namespace
}  // namespace penumbra::testing
