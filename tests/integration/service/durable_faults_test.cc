// What a server that keeps its scenes on disk makes of disks that fail, and of being killed.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <random>
#include <thread>

#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/field_error.h"
#include "tests/integration/service/import_call.h"
#include "tests/support/daemon.h"
#include "tests/support/faulty_vfs.h"
#include "tests/support/stalled_file.h"

namespace penumbra::testing {
namespace {

namespace fs = std::filesystem;

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
  ASSERT_EQ(session_->Commit(MoveBox({1, 1, 1})).revision(), 3u);
  disk.FailAfter(0, FaultyVfs::Call::kSync, SQLITE_IOERR_FSYNC);
  for (int i = 0; i < 3; ++i) {
    const auto failed = session_->Commit(MoveBox({2, 1, 0}));
    EXPECT_EQ(ErrorIn(failed).code(), absl::StatusCode::kUnavailable);
    EXPECT_EQ(failed.revision(), 3u);
  }
  const SceneInfo acknowledged = client_->FindScene("studio").value();
  disk.Heal();
  const auto healed = session_->Commit(MoveBox({3, 1, 0}), "after");
  EXPECT_EQ(healed.revision(), 4u) << ErrorIn(healed);
  EXPECT_TRUE(fs::exists(folder_ / "data/scenes/studio~2.db"));
  EXPECT_FALSE(fs::exists(folder_ / "data/scenes/studio~1.db"));
  options_.storage.database.vfs = nullptr;
  Restart();
  EXPECT_EQ(client_->FindScene("studio")->revision, 4u);
  session_ = client_->OpenSession("studio");
  EXPECT_EQ(session_->Commit(MoveBox({1, 1, 0}), "before").revision(), 2u) << "answers go along";
  EXPECT_EQ(session_->Commit(MoveBox({3, 1, 0}), "after").content_hash(), healed.content_hash());
  EXPECT_GT(healed.revision(), acknowledged.revision);
}

TEST_F(DurableScenesTest, D06ADeletionThatFailedIsDoneAgain) {
  Restart();
  MakeStudio();
  // A file of the scene that cannot be removed, for it is a folder.
  fs::create_directories(folder_ / "data/scenes/studio~2.db/inside");
  EXPECT_EQ(client_->DeleteScene("studio").code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(session_->End().code(), absl::StatusCode::kNotFound);
  v1::ListScenesResponse list;
  grpc::ClientContext context;
  ASSERT_TRUE(client_->stub().ListScenes(&context, {}, &list).ok());
  ASSERT_EQ(list.scenes_size(), 1);
  EXPECT_THAT(list.scenes(0).damage(), ::testing::HasSubstr("need it to be deleted again"));
  EXPECT_EQ(client_->CreateScene("studio").code(), absl::StatusCode::kAlreadyExists);
  EXPECT_EQ(EndOfSession("studio").code(), absl::StatusCode::kDataLoss);

  EXPECT_EQ(client_->DeleteScene("studio"), absl::OkStatus());
  EXPECT_EQ(client_->DeleteScene("studio").code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(client_->CreateScene("studio"), absl::OkStatus());
  Restart();
  EXPECT_EQ(client_->FindScene("studio")->revision, 0u);
}

TEST_F(DurableScenesTest, D06WhileOneWaitsForTheTableOfOwnersOthersGoOn) {
  Restart();
  MakeStudio();
  ImportCall import(*client_);
  ASSERT_TRUE(import.Send("imported", {}));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));  // until it has the id
  ASSERT_EQ(client_->CreateScene("imported").code(), absl::StatusCode::kAlreadyExists);
  StalledFile stalled(folder_ / "data/owners.new");
  auto creating = std::async(std::launch::async, [&] { return client_->CreateScene("waits"); });
  while (!client_->FindScene("waits").ok()) {
  }
  auto importing = std::async(std::launch::async, [&] { return import.End(); });
  EXPECT_EQ(importing.wait_for(std::chrono::seconds(10)), std::future_status::ready);
  auto commit = std::async(std::launch::async, [&] {
    return session_->Commit(MoveBox({1, 1, 0}));
  });
  EXPECT_EQ(commit.wait_for(std::chrono::seconds(10)), std::future_status::ready);
  EXPECT_EQ(creating.wait_for(std::chrono::seconds(0)), std::future_status::timeout);
  stalled.WakeUp();
  EXPECT_EQ(ErrorReason(importing.get()), "LENGTH") << "and what it had taken is given back";
  EXPECT_EQ(commit.get().revision(), 2u);
  EXPECT_EQ(creating.get().code(), absl::StatusCode::kUnavailable);
}

// Its client sent no deadline that counts.
TEST_F(DurableScenesTest, C17ACallThatTheDiskKeepsWaitingIsEndedByTheServer) {
  FaultyVfs disk;
  options_.storage.database.vfs = disk.name();
  options_.limits.transfer_idle_timeout = std::chrono::seconds(1);
  Restart();
  MakeStudio();
  disk.Stall();
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(client_->CreateScene("waits").code(), absl::StatusCode::kCancelled);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
  EXPECT_EQ(client_->FindScene("studio")->revision, 1u) << "others are answered meanwhile";
  disk.Heal();
  EXPECT_EQ(session_->Commit(MoveBox({1, 1, 0})).revision(), 2u);
  EXPECT_EQ(client_->CreateScene("another"), absl::OkStatus());
  EXPECT_TRUE(client_->FindScene("waits").ok()) << "it was made after all";
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
