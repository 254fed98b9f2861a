// Scenes that are edited so fast that their commits go to a journal, and what becomes of them.

#include "tests/integration/service/busy_scenes.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "proto/convert/scene_convert.h"
#include "render/scene/field_error.h"
#include "tests/support/faulty_vfs.h"

namespace penumbra::testing {
namespace {

namespace fs = std::filesystem;

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

TEST_F(BusyScenesTest, D04AreRefusedWithoutTheirJournalAndOthersAreServed) {
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

TEST_F(BusyScenesTest, D04AreRefusedWithADamagedJournalWhichIsLeftAsItIs) {
  CrashWhileBusy();
  const std::string log = Journal() + "-wal";
  std::string bytes;
  {
    std::ifstream stream(log, std::ios::binary);
    bytes.assign((std::istreambuf_iterator<char>(stream)), {});
  }
  bytes[bytes.size() / 3] ^= 1;
  std::ofstream(log, std::ios::binary) << bytes;
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
  std::ifstream stream(log, std::ios::binary);
  EXPECT_EQ(std::string((std::istreambuf_iterator<char>(stream)), {}), bytes);
}

}  // namespace
}  // namespace penumbra::testing
