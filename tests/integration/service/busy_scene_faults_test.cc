// Journals on disks that fail under a running server. Row D06.

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "render/scene/field_error.h"
#include "tests/integration/service/busy_scenes.h"
#include "tests/support/faulty_vfs.h"

namespace penumbra::testing {
namespace {

namespace fs = std::filesystem;

constexpr char kJournals[] = "/journals/";

class BusySceneFaultsTest : public BusyScenesTest {
 protected:
  BusySceneFaultsTest() { options_.storage.database.vfs = disk_.name(); }
  ~BusySceneFaultsTest() override {
    disk_.Heal();
    session_.reset();
    client_.reset();
    server_.reset();  // before the disk that it writes to
  }

  // Until a commit that was to go to the journal has failed, and been told to have: the scene is as
  // it was. Files with `part` in their paths go on failing.
  void DragUntilTheJournalFails(FaultyVfs::Call kind, int code, const char* part) {
    const size_t failures = logger_.All("journal_failed").size();
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (true) {
      ASSERT_LT(std::chrono::steady_clock::now(), end) << "no commit goes to the journal";
      ASSERT_NO_FATAL_FAILURE(DragUntilBusy());
      disk_.FailAfter(0, kind, code, part);
      lost_ = "lost" + std::to_string(++attempts_);
      const auto failed = session_->Commit(MoveBox({7, 1, 0}), lost_);
      if (logger_.All("journal_failed").size() > failures) {
        EXPECT_EQ(ErrorIn(failed).code(), absl::StatusCode::kUnavailable) << ErrorIn(failed);
        EXPECT_EQ(ErrorReason(ErrorIn(failed)), "STORAGE_FAILED");
        EXPECT_EQ(failed.revision(), before_.revision) << "the scene is as it was";
        return;
      }
      // It had come to rest, and the commit went to its own file.
      disk_.Heal();
    }
  }
  void ExpectReadsGoOn() {
    ExpectAsBefore();
    ASSERT_EQ(session_->Subscribe(++subscriptions_, FloorSpec(), 8), absl::OkStatus());
    EXPECT_TRUE(session_->AwaitUpdate(subscriptions_, FinalAt(before_.revision)).artifact);
  }
  void ExpectAsBeforeAfterACrash() {
    options_.storage.database.vfs = nullptr;
    Restart();
    ExpectAsBefore();
    session_ = client_->OpenSession("busy");
    EXPECT_EQ(session_->Commit(MoveBox({7, 1, 0}), lost_).revision(), before_.revision + 1)
        << "nobody knows of the one that failed";
  }

  FaultyVfs disk_;
  std::string lost_;  // key of the commit that failed
  int attempts_ = 0;
  uint64_t subscriptions_ = 0;
};

TEST_F(BusySceneFaultsTest, D06AnErrorOfTheJournalFailsOneCommitAndNoneAfterIt) {
  auto quiet = client_->OpenSession("quiet");
  DragUntilTheJournalFails(FaultyVfs::Call::kWrite, SQLITE_IOERR_WRITE, kJournals);
  ExpectReadsGoOn();
  // There is no journal, nor can one be made: all have their own files.
  for (int i = 0; i < 5; ++i) Drag();
  EXPECT_EQ(client_->FindScene("busy")->revision, before_.revision + 5);
  EXPECT_EQ(quiet->Commit(MoveBox({1, 1, 0})).revision(), 2u);
  quiet.reset();
  disk_.Heal();
  DragUntilBusy();  // in another journal
  BecomeCopy();
  options_.storage.database.vfs = nullptr;
  Restart();
  EXPECT_EQ(client_->FindScene("busy")->content_hash, before_.content_hash);
  EXPECT_EQ(client_->FindScene("busy")->revision, before_.revision);
  EXPECT_EQ(client_->FindScene("quiet")->revision, 2u);
}

// The commit is in the journal's log, and a reader would find it there.
TEST_F(BusySceneFaultsTest, D06WhatTheJournalCouldNotSyncIsNotThereAfterACrash) {
  DragUntilTheJournalFails(FaultyVfs::Call::kSync, SQLITE_IOERR_FSYNC, kJournals);
  // The scene lets go of it without another commit.
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!fs::is_empty(folder_ / "data/journals") && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_TRUE(fs::is_empty(folder_ / "data/journals"));
  ExpectReadsGoOn();
  Copy();
  BecomeCopy();
  ExpectAsBeforeAfterACrash();
}

TEST_F(BusySceneFaultsTest, D06WhenAllOfTheDiskFailsCommitsWaitForItToWork) {
  DragUntilTheJournalFails(FaultyVfs::Call::kSync, SQLITE_IOERR_FSYNC, "");
  for (int i = 0; i < 3; ++i) {
    const auto failed = session_->Commit(MoveBox({7, 1, 0}), lost_);
    EXPECT_EQ(ErrorIn(failed).code(), absl::StatusCode::kUnavailable) << ErrorIn(failed);
    EXPECT_EQ(failed.revision(), before_.revision);
  }
  ExpectReadsGoOn();
  disk_.Heal();
  Drag();
  EXPECT_EQ(client_->FindScene("busy")->revision, before_.revision + 1);
  DragUntilBusy();  // in a journal again
  BecomeCopy();
  ExpectAsBeforeAfterACrash();
}

}  // namespace
}  // namespace penumbra::testing
