// Journals that busy scenes share, when power is lost and when one is full. Rows D01 and D02.
#include "server/scene_store/shared_journal.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "tests/support/disk_image.h"
#include "tests/support/faulty_vfs.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/server/logged_scenes.h"

namespace penumbra::testing {
namespace {

namespace fs = std::filesystem;

using Luck = DiskImage::Luck;

const std::vector<std::string> kBoth = {"ada", "bob"};

std::set<std::string> JournalsIn(const std::string& data) {
  std::set<std::string> paths;
  for (const auto& entry : fs::directory_iterator(data + "/journals")) {
    paths.insert(entry.path().string());
  }
  return paths;
}

class JournalPowerTest : public ::testing::Test {
 protected:
  void SetUp() override { LoggedScenes::Make(folder_ / "empty", kBoth); }

  // All that journals are for, until something fails.
  absl::Status Work(LoggedScenes& scenes) {
    if (auto status = scenes.Open(); !status.ok()) return status;
    for (const std::string& id : kBoth) {
      if (auto status = scenes.MakeBusy(id); !status.ok()) return status;
    }
    for (int i = 0; i < 6; ++i) {
      const auto written = scenes.CommitTogether(kBoth);
      if (!written.status.ok()) return written.status;
      groups_ += static_cast<int>(written.journals.size());
      absl::Status status;
      // Both move what is in the journal into a scene's own file, which goes on in the journal.
      if (i == 2) status = scenes.CommitToFile("ada");
      if (i == 4) status = scenes.log("bob").SnapshotFor(1).status();
      if (!status.ok()) return status;
    }
    return absl::OkStatus();
  }

  // Loses power at the call after `calls` more, if there are as many; whether there were. Then a
  // server starts.
  bool LosePowerAfter(int64_t calls, Luck luck) {
    const std::string data = folder_ / ("data" + std::to_string(lives_++));
    fs::copy(folder_ / "empty", data, fs::copy_options::recursive);
    vfs_.FailAfter(calls, FaultyVfs::Call::kAny, SQLITE_IOERR);
    std::map<std::string, Revision> acknowledged = {{"ada", 0}, {"bob", 0}};
    {
      LoggedScenes scenes(data, options_);
      const absl::Status worked = Work(scenes);
      EXPECT_TRUE(worked.ok() || vfs_.failures() > 0) << worked;
      for (const auto& [id, revision] : scenes.acknowledged()) acknowledged[id] = revision;
    }
    const bool has_gone = vfs_.failures() > 0;
    vfs_.Heal();
    // The image does not hear of journals that are removed; these are for good.
    const std::set<std::string> there = JournalsIn(data);
    disk_.LosePower(has_gone ? luck : Luck::kEverything, random_);
    vfs_.FailAfter(0, FaultyVfs::Call::kNone, SQLITE_OK);
    for (const std::string& path : JournalsIn(data)) {
      if (!there.contains(path)) fs::remove(path);
    }
    ExpectRestored(data, options_, acknowledged, /*later=*/1, "call " + std::to_string(calls));
    fs::remove_all(data);
    return has_gone;
  }

  const TemporaryFolder folder_;
  DiskImage disk_;
  FaultyVfs vfs_{&disk_};
  const SceneLogOptions options_{.database = {.vfs = vfs_.name()}};
  std::mt19937 random_{23};
  int lives_ = 0;
  int groups_ = 0;  // that have gone to a journal
};

TEST_F(JournalPowerTest, D02WhatWasAcknowledgedIsInTheJournalOrInTheScenesFile) {
  for (const bool is_mixed : {true, false}) {
    int64_t call = 0;
    const auto luck = [&] {
      if (is_mixed) return Luck::kSome;
      return call % 2 == 0 ? Luck::kNothing : Luck::kEverything;
    };
    while (LosePowerAfter(call, luck())) ++call;
    EXPECT_GT(call, 60) << "as many calls were the last";
  }
  EXPECT_GT(groups_, 100) << "scenes were busy";
}

class FullJournalTest : public ::testing::Test {
 protected:
  void SetUp() override {
    LoggedScenes::Make(folder_ / "data", {"early", "late"});
    scenes_ = std::make_unique<LoggedScenes>(folder_ / "data", SceneLogOptions());
    ASSERT_EQ(scenes_->Open(), absl::OkStatus());
  }

  // What a scene that has been deleted since left in the journal, until another takes its place.
  void FillJournal() {
    const CommitRecord commit{.revision = 1, .delta = std::string(1u << 20, 'x')};
    const JournalEntry entry{.incarnation = std::string(16, 'g'),
                             .chained = {commit, LinkOf(ContentHash(), commit)}};
    const JournalEntries entries = {std::span(&entry, 1)};
    const std::string id = scenes_->journals().Current().value()->id();
    for (int megabytes = 0;; ++megabytes) {
      const auto journal = scenes_->journals().Current().value();
      if (journal->id() != id) break;
      ASSERT_LT(megabytes, 100) << "and there is no other yet";
      ASSERT_EQ(scenes_->journals().Append(*journal, entries), absl::OkStatus());
    }
  }
  // What a kill leaves at this moment.
  void ExpectWholeAfterACrash(const std::string& what) {
    fs::copy(folder_ / "data", folder_ / "copy", fs::copy_options::recursive);
    ExpectRestored(folder_ / "copy", {}, scenes_->acknowledged(), /*later=*/0, what);
    fs::remove_all(folder_ / "copy");
  }
  std::string Journal(int number) {
    return folder_ / ("data/journals/" + std::to_string(number) + ".db");
  }

  const TemporaryFolder folder_;
  std::unique_ptr<LoggedScenes> scenes_;
};

TEST_F(FullJournalTest, D01ScenesAreWholeWithTheirCommitsInTwoJournals) {
  ASSERT_EQ(scenes_->MakeBusy("early"), absl::OkStatus());
  ASSERT_EQ(scenes_->CommitTogether({"early"}, 5).journals.size(), 1u);
  FillJournal();
  ASSERT_EQ(scenes_->MakeBusy("late"), absl::OkStatus());
  for (int i = 0; i < 5; ++i) {
    const auto written = scenes_->CommitTogether({"early", "late"});
    ASSERT_EQ(written.status, absl::OkStatus());
    EXPECT_EQ(written.journals.size(), 2u) << "the early one goes on where it was";
  }
  EXPECT_TRUE(fs::exists(Journal(1)));
  EXPECT_TRUE(fs::exists(Journal(2)));
  ExpectWholeAfterACrash("in two journals");

  // With much in it the early one moves to the newer journal, and nobody needs the older.
  while (!scenes_->log("early").is_tidying_due()) {
    ASSERT_EQ(scenes_->CommitTogether({"early"}, 50).status, absl::OkStatus());
  }
  ASSERT_EQ(scenes_->log("early").Tidy([] { return SnapshotRecord(); }), absl::OkStatus());
  const auto together = scenes_->CommitTogether({"early", "late"});
  EXPECT_EQ(together.status, absl::OkStatus());
  EXPECT_EQ(together.journals.size(), 1u);
  EXPECT_FALSE(fs::exists(Journal(1)));
  EXPECT_FALSE(fs::exists(Journal(1) + "-wal"));
  ExpectWholeAfterACrash("in the newer journal");
}

// A scene that has not moved names the old one, also when it is the only one that does.
TEST_F(FullJournalTest, D01AFullJournalStaysForAsLongAsASceneNamesIt) {
  ASSERT_EQ(scenes_->MakeBusy("early"), absl::OkStatus());
  ASSERT_EQ(scenes_->CommitTogether({"early"}, 5).journals.size(), 1u);
  FillJournal();
  ASSERT_EQ(scenes_->MakeBusy("late"), absl::OkStatus());
  ASSERT_EQ(scenes_->CommitTogether({"late"}).journals.size(), 1u);
  EXPECT_TRUE(fs::exists(Journal(1)));
  ExpectWholeAfterACrash("with the old one named");
  // A reader of its history has the file take over what is there, and it still names the old one.
  ASSERT_EQ(scenes_->log("early").SnapshotFor(1).status(), absl::OkStatus());
  EXPECT_EQ(scenes_->CommitTogether({"early", "late"}).journals.size(), 2u);
  ExpectWholeAfterACrash("after its history was read");
  const auto acknowledged = scenes_->acknowledged();
  scenes_.reset();
  EXPECT_TRUE(fs::is_empty(folder_ / "data/journals"));
  ExpectRestored(folder_ / "data", {}, acknowledged, /*later=*/0, "in their own files");
}

}  // namespace
}  // namespace penumbra::testing
