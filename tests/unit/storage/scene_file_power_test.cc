// Rows D02 and D10 of the catalogue: power is lost at each call to the disk, and again while what
// was left is being opened. What was acknowledged is there and whole.

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "server/storage/durable_file.h"
#include "server/storage/scene_file.h"
#include "tests/support/disk_image.h"
#include "tests/support/faulty_vfs.h"
#include "tests/support/scene_records.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

using Luck = DiskImage::Luck;

constexpr Revision kCommits = 20;
constexpr HistoryLimits kShort{.commits = 5};

class SceneFilePowerTest : public ::testing::Test {
 protected:
  DatabaseOptions disk() const { return {.vfs = vfs_.name()}; }

  // From here on the power goes at the call after `calls` more.
  void PowerGoesAfter(int64_t calls) { vfs_.FailAfter(calls, FaultyVfs::Call::kAny, SQLITE_IOERR); }
  // Whether it had gone. The disk is as such a loss leaves it, and works again.
  bool ComeBack(Luck luck) {
    const bool has_gone = vfs_.failures() > 0;
    vfs_.Heal();
    disk_.LosePower(has_gone ? luck : Luck::kEverything, random_);
    vfs_.FailAfter(0, FaultyVfs::Call::kNone, SQLITE_OK);
    return has_gone;
  }

  // Makes a file, commits, and compacts it now and then. The head that was acknowledged last.
  Revision Work(const std::string& path) {
    Revision acknowledged = 0;
    auto file = SceneFile::Create(path, StudioIdentity(), disk());
    if (!file.ok()) return acknowledged;
    for (Revision revision = 1; revision <= kCommits; ++revision) {
      if (!(*file)->Append(CommitsBetween(revision, revision)).ok()) break;
      acknowledged = revision;
      if (revision % 8 == 0 && !(*file)->AppendSnapshot(SnapshotAt(revision), kShort).ok()) break;
      if (revision == 12 && !(*file)->Settle().ok()) break;
    }
    (*file)->Abandon();
    return acknowledged;
  }

  // As a server does when it starts, and then a snapshot and a commit.
  void Recover(const std::string& path) {
    auto file = SceneFile::Open(path, disk());
    if (!file.ok()) return;
    const Revision head = (*file)->head().revision;
    if (head > 0 && (*file)->Settle().ok() &&
        (*file)->AppendSnapshot(SnapshotAt(head), kShort).ok() && (*file)->Settle().ok()) {
      (*file)->Append(CommitsBetween(head + 1, head + 1)).IgnoreError();
    }
    (*file)->Abandon();
  }

  // `later`: how many commits may be there that nobody has heard of.
  static void ExpectWhole(const std::string& path, Revision acknowledged, Revision later,
                          const std::string& what) {
    if (ReadFileIfThere(path)->empty()) {
      EXPECT_EQ(acknowledged, 0u) << what;
      return;
    }
    auto file = SceneFile::Open(path, {});
    ASSERT_EQ(file.status(), absl::OkStatus()) << what;
    const Revision head = (*file)->head().revision;
    EXPECT_GE(head, acknowledged) << what;
    EXPECT_LE(head, acknowledged + later) << what;
    const auto state = (*file)->StateAt(head);
    ASSERT_EQ(state.status(), absl::OkStatus()) << what;
    const Revision from = state->snapshot ? state->snapshot->revision : 0;
    SceneState expected{.commits = CommitsBetween(from + 1, head)};
    if (from > 0) expected.snapshot = SnapshotAt(from);
    EXPECT_EQ(TextOf(*state), TextOf(expected)) << what;
    EXPECT_EQ((*file)->Append(CommitsBetween(head + 1, head + 1)), absl::OkStatus()) << what;
    (*file)->Abandon();
  }

  static std::string Text(Luck luck, int64_t call) {
    constexpr const char* kNames[] = {"nothing", "everything", "some"};
    return std::string(kNames[static_cast<size_t>(luck)]) + " after call " + std::to_string(call);
  }

  TemporaryFolder folder_;
  DiskImage disk_;
  FaultyVfs vfs_{&disk_};
  std::mt19937 random_{11};
};

TEST_F(SceneFilePowerTest, D02WhatWasAcknowledgedIsThereWhateverOfTheRestIs) {
  int files = 0;
  for (const Luck luck : {Luck::kNothing, Luck::kEverything, Luck::kSome, Luck::kSome}) {
    bool has_gone = true;
    int64_t call = 0;
    for (; has_gone; ++call) {
      const std::string path = folder_ / ("scene" + std::to_string(files++) + ".db");
      PowerGoesAfter(call);
      const Revision acknowledged = Work(path);
      has_gone = ComeBack(luck);
      ExpectWhole(path, acknowledged, 1, Text(luck, call));
      if (!has_gone) {
        EXPECT_EQ(acknowledged, kCommits);
      }
    }
    EXPECT_GT(call, 60) << "as many calls were the last";
  }
}

TEST_F(SceneFilePowerTest, D10PowerThatIsLostAgainWhileAFileIsOpenedOrCompacted) {
  int files = 0;
  for (const int64_t first : {41, 52, 63, 74}) {
    bool has_gone = true;
    int64_t call = 0;
    for (; has_gone; ++call) {
      const std::string path = folder_ / ("scene" + std::to_string(files++) + ".db");
      PowerGoesAfter(first);
      const Revision acknowledged = Work(path);
      ComeBack(Luck::kSome);
      if (ReadFileIfThere(path)->empty()) break;
      PowerGoesAfter(call);
      Recover(path);
      has_gone = ComeBack(Luck::kSome);
      ExpectWhole(path, acknowledged, 2,
                  std::to_string(first) + ", then " + Text(Luck::kSome, call));
    }
    EXPECT_GT(call, 10) << first;
  }
}

}  // namespace
}  // namespace penumbra::testing
