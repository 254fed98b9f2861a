// Scenes that are edited so fast that their commits go to a journal, and what becomes of them.

#include "tests/integration/service/busy_scenes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>

#include "proto/convert/scene_convert.h"
#include "render/scene/field_error.h"
#include "render/scene/retry_delay.h"
#include "tests/support/faulty_vfs.h"

namespace penumbra::testing {
namespace {

namespace fs = std::filesystem;

// What a server does that starts and cannot read all of them.
class UnreadableScenesTest : public BusyScenesTest {
 protected:
  // On a disk without room, which is looked at again every second.
  void RestartOn(FaultyVfs& disk) {
    options_.storage.database.vfs = disk.name();
    options_.storage.refused_interval = std::chrono::seconds(1);
    disk.FailAfter(0, FaultyVfs::Call::kWrite, SQLITE_FULL);
    Restart();
  }

  // Where the folder of journals was there is none that can be read.
  void RestartWithoutJournals() {
    CrashWhileBusy();
    fs::rename(folder_ / "data/journals", folder_ / "journals");
    std::ofstream(folder_ / "data/journals") << "no folder";
    Restart();
    EXPECT_EQ(logger_.Await("scene_unavailable", 1)[0]["scene"], "busy");
    EXPECT_EQ(logger_.All("journals_unreadable").size(), 1u);
    EXPECT_EQ(client_->FindScene("quiet")->revision, 1u);
  }
  void PutJournalsBack() {
    fs::remove(folder_ / "data/journals");
    fs::rename(folder_ / "journals", folder_ / "data/journals");
  }

  static std::string BytesOf(const std::string& path) {
    std::ifstream stream(path, std::ios::binary);
    return {(std::istreambuf_iterator<char>(stream)), {}};
  }
  // Changes a bit; what the file is then.
  static std::string Damage(const std::string& path) {
    std::string bytes = BytesOf(path);
    bytes[bytes.size() / 3] ^= 1;
    std::ofstream(path, std::ios::binary) << bytes;
    return bytes;
  }
  // While the busy scene is refused another one comes to have a journal, and is whole again.
  void ExpectOnlyItsJournalIsKept(const std::string& damaged) {
    CrashWhileBusy();
    const SceneInfo busy = before_;
    const std::string whole = BytesOf(damaged);
    Damage(damaged);
    Restart();
    ExpectRefused();
    MakeOther();
    DragUntilBusy();
    const Revision other = client_->FindScene("other")->revision;
    ASSERT_TRUE(fs::exists(folder_ / "data/journals/2.db"));
    Crash();
    Restart();
    EXPECT_EQ(client_->FindScene("other")->revision, other);
    EXPECT_FALSE(fs::exists(folder_ / "data/journals/2.db"));
    EXPECT_FALSE(fs::exists(folder_ / "data/journals/2.db-wal"));
    // Nothing has gone that the scene needs once it can be read.
    Crash();
    std::ofstream(damaged, std::ios::binary) << whole;
    Restart();
    before_ = busy;
    ExpectAsBefore();
  }
};

TEST_F(BusyScenesTest, D01AreWholeAfterACrash) {
  CrashWhileBusy();
  Restart();
  ExpectAsBefore();
  session_ = client_->OpenSession("busy");
  EXPECT_EQ(session_->Commit(Place(drags_), KeyOf(drags_)).revision(), before_.revision)
      << "it is known";
  EXPECT_EQ(session_->Commit(MoveBox({0, 1, 3})).revision(), before_.revision + 1);
  // Nothing is left to be done a second time.
  Restart();
  EXPECT_EQ(client_->FindScene("busy")->revision, before_.revision + 1);
}

// Those that come while the disk does not answer go to the journal together.
TEST_F(BusyScenesTest, D01AreWholeAfterACrashWhenManyOfTheirCommitsWereWrittenTogether) {
  FaultyVfs disk;
  options_.storage.database.vfs = disk.name();
  options_.limits.max_commit_delay_ms = 60'000;
  Restart();
  session_ = client_->OpenSession("busy");
  DragUntilBusy();
  disk.Stall();
  for (int i = 1; i <= 20; ++i) {
    v1::SessionRequest request;
    *request.mutable_commit()->mutable_delta() = ToProto(Place(drags_ + i));
    session_->Send(request);
  }
  // A request that says nothing is refused once the server has come to it: all the others wait.
  const size_t refused = logger_.All("refused").size();
  session_->Send(v1::SessionRequest());
  EXPECT_EQ(logger_.Await("refused", refused + 1).back()["reason"], "MISSING_FIELD");
  disk.Heal();
  for (Revision revision = before_.revision + 1; revision <= before_.revision + 20; ++revision) {
    const auto answer = session_->ReadUntil(v1::SessionResponse::kCommitResult);
    EXPECT_EQ(answer ? answer->commit_result().revision() : 0, revision);
  }
  before_ = client_->FindScene("busy").value();
  Copy();
  BecomeCopy();
  options_.storage.database.vfs = nullptr;
  Restart();
  ExpectAsBefore();
}

TEST_F(BusyScenesTest, AreInTheirOwnFilesOnceTheyRest) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  for (bool is_resting = false; !is_resting;) {
    ASSERT_LT(std::chrono::steady_clock::now(), end) << "its file still names the journal";
    Copy();
    const auto file = SceneFileIn(folder_ / "copy", "busy");
    is_resting = file && file->journal().empty();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  BecomeCopy();
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

TEST_F(UnreadableScenesTest, D04AreRefusedWithoutTheirJournalAndOthersAreServed) {
  CrashWhileBusy();
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

TEST_F(UnreadableScenesTest, D04AreRefusedWithADamagedJournalWhichIsLeftAsItIs) {
  CrashWhileBusy();
  const std::string log = Journal() + "-wal";
  const std::string bytes = Damage(log);
  const auto kept_bytes = fs::file_size(Journal()) + bytes.size();
  for (int i = 1; i <= 2; ++i) {
    Restart();
    auto kept = logger_.Await("journals_kept", static_cast<size_t>(i)).back();
    EXPECT_EQ(kept["journals"], 1);
    EXPECT_EQ(kept["bytes"], kept_bytes);
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

TEST_F(UnreadableScenesTest, D04ASceneWithADamagedJournalKeepsThatOneAndNoOther) {
  ExpectOnlyItsJournalIsKept(Journal() + "-wal");
}

TEST_F(UnreadableScenesTest, D05AFullDiskAtTheStartIsNoDamageAndTheyAreBackWhenThereIsRoom) {
  FaultyVfs disk;
  CrashWhileBusy();
  RestartOn(disk);
  EXPECT_EQ(logger_.Await("scene_unavailable", 2)[0]["scene"], "busy");
  EXPECT_TRUE(logger_.All("scene_refused").empty());
  const absl::Status refused = EndOfSession("busy");
  EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ErrorReason(refused), "DISK_FULL");
  EXPECT_THAT(refused.message(), ::testing::HasSubstr("which cannot be read for now"));
  EXPECT_EQ(RetryDelayMs(refused).value_or(0), 1'000) << "then it is looked at again";
  EXPECT_EQ(client_->CreateScene("busy").code(), absl::StatusCode::kAlreadyExists);
  std::this_thread::sleep_for(std::chrono::milliseconds(2'200));
  EXPECT_EQ(logger_.All("scene_unavailable").size(), 2u) << "told once";
  disk.Heal();
  logger_.Await("scene_is_back", 2);
  ExpectAsBefore();
  session_ = client_->OpenSession("busy");
  EXPECT_EQ(session_->Commit(MoveBox({0, 1, 3})).revision(), before_.revision + 1);
  options_.storage.database.vfs = nullptr;
  Restart();
  EXPECT_EQ(client_->FindScene("busy")->revision, before_.revision + 1);
  EXPECT_FALSE(fs::exists(Journal()));
}

TEST_F(UnreadableScenesTest, D05WhatIsDeletedWhileTheDiskIsFullIsPutAsideWithItsJournal) {
  FaultyVfs disk;
  CrashWhileBusy();
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

TEST_F(UnreadableScenesTest, AreBackOnceTheFolderOfJournalsCanBeRead) {
  options_.storage.house_interval = std::chrono::seconds(1);
  RestartWithoutJournals();
  EXPECT_EQ(ErrorReason(EndOfSession("busy")), "STORAGE_FAILED");
  PutJournalsBack();
  EXPECT_EQ(logger_.Await("scene_is_back", 1)[0]["scene"], "busy");
  ExpectAsBefore();
  Restart();
  ExpectAsBefore();
  EXPECT_FALSE(fs::exists(Journal()));
}

TEST_F(UnreadableScenesTest, AreDeletedWithoutTheJournalsThatOthersHaveMadeSince) {
  RestartWithoutJournals();
  PutJournalsBack();
  MakeOther();
  DragUntilBusy();
  ASSERT_TRUE(fs::exists(folder_ / "copy/journals/2.db"));
  EXPECT_EQ(client_->DeleteScene("busy"), absl::OkStatus());
  EXPECT_EQ(logger_.Await("scene_put_aside", 1)[0]["journals"], 1);
}

TEST_F(UnreadableScenesTest, ADamagedJournalThatNoSceneNeedsIsNoDamage) {
  CrashWhileBusy();
  const std::string unused = folder_ / "data/journals/7.db";
  std::ofstream(unused, std::ios::binary) << "no journal";
  Restart();
  ExpectAsBefore();
  const auto removed = logger_.Await("unused_journal_removed", 1)[0];
  EXPECT_EQ(removed["journal"], 7);
  EXPECT_EQ(removed["level"], "info");
  EXPECT_TRUE(logger_.All("journal_damaged").empty());
  EXPECT_TRUE(logger_.All("journals_kept").empty());
  EXPECT_FALSE(fs::exists(unused));
}

TEST_F(UnreadableScenesTest, D04ASceneWithADamagedFileKeepsItsJournalAndNoOther) {
  ExpectOnlyItsJournalIsKept(SceneFileOf("busy") + "-wal");
}

}  // namespace
}  // namespace penumbra::testing
