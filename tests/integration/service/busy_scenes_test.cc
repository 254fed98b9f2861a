// Scenes that are edited so fast that their commits go to a journal, and what becomes of them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "proto/convert/scene_convert.h"
#include "render/scene/field_error.h"
#include "tests/integration/service/durable_scenes.h"
#include "tests/support/faulty_vfs.h"

namespace penumbra::testing {
namespace {

namespace fs = std::filesystem;

class BusyScenesTest : public DurableScenesTest {
 protected:
  // A scene that is edited now and then, and one that somebody drags things in.
  void SetUp() override {
    Restart();
    MakeStudio("quiet");
    MakeStudio("busy");
    for (int i = 1; i <= 20; ++i) Drag(i);
    ASSERT_FALSE(fs::is_empty(folder_ / "data/journals"));
    before_ = client_->FindScene("busy").value();
    EXPECT_EQ(before_.revision, 21u);
  }
  void Drag(int i) {
    const std::string key = "drag" + std::to_string(i);
    ASSERT_FALSE(session_->Commit(MoveBox({0, 1, 0.01f * static_cast<float>(i)}), key).has_error());
  }
  // The folder as it is at this moment, as a kill leaves it, becomes the server's.
  void Crash() {
    fs::remove_all(folder_ / "copy");
    fs::copy(folder_ / "data", folder_ / "copy", fs::copy_options::recursive);
    session_.reset();
    client_.reset();
    server_.reset();
    fs::remove_all(folder_ / "data");
    fs::rename(folder_ / "copy", folder_ / "data");
  }
  // Changes a bit; what the file is then.
  static std::string Damage(const std::string& path) {
    std::string bytes = BytesOf(path);
    bytes[bytes.size() / 3] ^= 1;
    std::ofstream(path, std::ios::binary) << bytes;
    return bytes;
  }
  static std::string BytesOf(const std::string& path) {
    std::ifstream stream(path, std::ios::binary);
    return {(std::istreambuf_iterator<char>(stream)), {}};
  }
  std::string Journal() { return folder_ / "data/journals/1.db"; }
  void ExpectAsBefore() {
    const SceneInfo after = client_->FindScene("busy").value();
    EXPECT_EQ(after.revision, before_.revision);
    EXPECT_EQ(after.content_hash, before_.content_hash);
    EXPECT_EQ(client_->FindScene("quiet")->revision, 1u);
  }
  void ExpectRefused() {
    EXPECT_EQ(logger_.Await("scene_refused", 1)[0]["scene"], "busy");
    EXPECT_EQ(EndOfSession("busy").code(), absl::StatusCode::kDataLoss);
    EXPECT_EQ(client_->FindScene("quiet")->revision, 1u) << "nothing of it is in the journal";
  }
  // On a disk without room, which is looked at again every second.
  void RestartOn(FaultyVfs& disk) {
    options_.storage.database.vfs = disk.name();
    options_.storage.house_interval = std::chrono::seconds(1);
    disk.FailAfter(0, FaultyVfs::Call::kWrite, SQLITE_FULL);
    Restart();
  }
  // While the busy scene is refused another one comes to have a journal, and is whole again.
  void ExpectOnlyItsJournalIsKept(const std::string& damaged) {
    Crash();
    const std::string whole = BytesOf(damaged);
    Damage(damaged);
    Restart();
    ExpectRefused();
    MakeStudio("other");
    for (int i = 1; i <= 20; ++i) Drag(i);
    ASSERT_TRUE(fs::exists(folder_ / "data/journals/2.db"));
    Crash();
    Restart();
    EXPECT_EQ(client_->FindScene("other")->revision, 21u);
    EXPECT_FALSE(fs::exists(folder_ / "data/journals/2.db"));
    EXPECT_FALSE(fs::exists(folder_ / "data/journals/2.db-wal"));
    // Nothing has gone that the scene needs once it can be read.
    Crash();
    std::ofstream(damaged, std::ios::binary) << whole;
    Restart();
    ExpectAsBefore();
  }

  SceneInfo before_;
};

TEST_F(BusyScenesTest, D01AreWholeAfterACrash) {
  Crash();
  Restart();
  ExpectAsBefore();
  session_ = client_->OpenSession("busy");
  EXPECT_EQ(session_->Commit(MoveBox({0, 1, 0.2f}), "drag20").revision(), 21u) << "it is known";
  EXPECT_EQ(session_->Commit(MoveBox({0, 1, 3})).revision(), 22u);
  // Nothing is left to be done a second time.
  Restart();
  EXPECT_EQ(client_->FindScene("busy")->revision, 22u);
}

// Those that come while the disk does not answer go to the journal together.
TEST_F(BusyScenesTest, D01AreWholeAfterACrashWhenManyOfTheirCommitsWereWrittenTogether) {
  FaultyVfs disk;
  options_.storage.database.vfs = disk.name();
  options_.limits.max_commit_delay_ms = 60'000;
  Restart();
  session_ = client_->OpenSession("busy");
  for (int i = 21; i <= 25; ++i) Drag(i);
  ASSERT_FALSE(fs::is_empty(folder_ / "data/journals"));
  disk.Stall();
  for (int i = 26; i <= 45; ++i) {
    v1::SessionRequest request;
    const SceneDelta delta = MoveBox({0, 1, 0.01f * static_cast<float>(i)});
    *request.mutable_commit()->mutable_delta() = ToProto(delta);
    session_->Send(request);
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // until all of them wait
  disk.Heal();
  for (Revision revision = 27; revision <= 46; ++revision) {
    const auto answer = session_->ReadUntil(v1::SessionResponse::kCommitResult);
    EXPECT_EQ(answer ? answer->commit_result().revision() : 0, revision);
  }
  before_ = client_->FindScene("busy").value();
  Crash();
  options_.storage.database.vfs = nullptr;
  Restart();
  ExpectAsBefore();
}

TEST_F(BusyScenesTest, AreInTheirOwnFilesOnceTheyRest) {
  std::this_thread::sleep_for(std::chrono::milliseconds(2'500));
  Crash();
  fs::remove_all(folder_ / "data/journals");
  Restart();
  ExpectAsBefore();
}

TEST_F(BusyScenesTest, AreInTheirOwnFilesOnceTheServerEnds) {
  session_.reset();
  client_.reset();
  server_.reset();
  EXPECT_TRUE(fs::is_empty(folder_ / "data/journals"));
  Restart();
  ExpectAsBefore();
}

TEST_F(BusyScenesTest, D04AreRefusedWithoutTheirJournalAndOthersAreServed) {
  Crash();
  fs::rename(Journal(), folder_ / "kept.db");
  fs::rename(Journal() + "-wal", folder_ / "kept.db-wal");
  Restart();
  ExpectRefused();
  // Once it is back they are whole.
  session_.reset();
  client_.reset();
  server_.reset();
  fs::rename(folder_ / "kept.db", Journal());
  fs::rename(folder_ / "kept.db-wal", Journal() + "-wal");
  Restart();
  ExpectAsBefore();
}

TEST_F(BusyScenesTest, D04AreRefusedWithADamagedJournalWhichIsLeftAsItIs) {
  Crash();
  const std::string log = Journal() + "-wal";
  const std::string bytes = Damage(log);
  for (int i = 1; i <= 2; ++i) {
    Restart();
    EXPECT_EQ(logger_.Await("journal_damaged", static_cast<size_t>(i)).size(),
              static_cast<size_t>(i));
    ExpectRefused();
    MakeStudio("other" + std::to_string(i));
    for (int j = 0; j < 10; ++j) {
      EXPECT_FALSE(session_->Commit(MoveBox({0, 1, 0.1f * static_cast<float>(j)})).has_error());
    }
  }
  EXPECT_EQ(BytesOf(log), bytes);
}

TEST_F(BusyScenesTest, D04ASceneWithADamagedJournalKeepsThatOneAndNoOther) {
  ExpectOnlyItsJournalIsKept(Journal() + "-wal");
}

TEST_F(BusyScenesTest, D05AFullDiskAtTheStartIsNoDamageAndTheyAreBackWhenThereIsRoom) {
  FaultyVfs disk;
  Crash();
  RestartOn(disk);
  EXPECT_EQ(logger_.Await("scene_unavailable", 2)[0]["scene"], "busy");
  EXPECT_TRUE(logger_.All("scene_refused").empty());
  const absl::Status refused = EndOfSession("busy");
  EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ErrorReason(refused), "DISK_FULL");
  EXPECT_THAT(refused.message(), ::testing::HasSubstr("which cannot be read for now"));
  EXPECT_EQ(client_->CreateScene("busy").code(), absl::StatusCode::kAlreadyExists);
  disk.Heal();
  logger_.Await("scene_is_back", 2);
  ExpectAsBefore();
  session_ = client_->OpenSession("busy");
  EXPECT_EQ(session_->Commit(MoveBox({0, 1, 3})).revision(), 22u);
  options_.storage.database.vfs = nullptr;
  Restart();
  EXPECT_EQ(client_->FindScene("busy")->revision, 22u);
  EXPECT_FALSE(fs::exists(Journal()));
}

TEST_F(BusyScenesTest, D05WhatIsDeletedWhileTheDiskIsFullIsPutAsideWithItsJournal) {
  FaultyVfs disk;
  Crash();
  RestartOn(disk);
  EXPECT_EQ(client_->DeleteScene("busy"), absl::OkStatus());
  EXPECT_EQ(logger_.Await("scene_put_aside", 1)[0]["journals"], 1);
  options_.storage.database.vfs = nullptr;
  Restart();
  EXPECT_EQ(client_->FindScene("busy").status().code(), absl::StatusCode::kNotFound);
  EXPECT_FALSE(fs::exists(Journal()));
  // As operations.md says.
  Crash();
  for (const auto& file : fs::directory_iterator(folder_ / "data/removed")) {
    const std::string name = file.path().filename().string();
    const size_t tilde = name.find('~'), journal = name.find("journal-");
    const std::string back = journal == std::string::npos
                                 ? "data/scenes/busy" + name.substr(tilde)
                                 : "data/journals/" + name.substr(journal + 8);
    fs::copy_file(file.path(), folder_ / back);
  }
  Restart();
  ExpectAsBefore();
}

TEST_F(BusyScenesTest, ADamagedJournalThatNoSceneNeedsIsNoDamage) {
  Crash();
  const std::string unused = folder_ / "data/journals/7.db";
  std::ofstream(unused, std::ios::binary) << "no journal";
  Restart();
  ExpectAsBefore();
  const auto removed = logger_.Await("unused_journal_removed", 1)[0];
  EXPECT_EQ(removed["journal"], 7);
  EXPECT_EQ(removed["level"], "info");
  EXPECT_TRUE(logger_.All("journal_damaged").empty());
  EXPECT_FALSE(fs::exists(unused));
}

TEST_F(BusyScenesTest, D04ASceneWithADamagedFileKeepsItsJournalAndNoOther) {
  ExpectOnlyItsJournalIsKept(SceneFileOf("busy") + "-wal");
}

}  // namespace
}  // namespace penumbra::testing
