// A disk that fails at each of its calls in turn: what was acknowledged is there, and what was not
// is whole or not there. Rows D05 and D06 of the catalogue.

#include <gtest/gtest.h>

#include <string>

#include "server/storage/durable_file.h"
#include "server/storage/scene_file.h"
#include "tests/support/faulty_vfs.h"
#include "tests/support/scene_records.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

class SceneFileFaultsTest : public ::testing::Test {
 protected:
  // Appends, and a snapshot, until one fails. The head that was acknowledged last.
  Revision RunUntilFailure(const std::string& path) {
    Revision acknowledged = 0;
    auto file = SceneFile::Create(path, StudioIdentity(), {.vfs = vfs_.name()});
    if (!file.ok()) return acknowledged;
    for (Revision revision = 1; revision <= kCommits; ++revision) {
      if (!(*file)->Append(CommitsBetween(revision, revision)).ok()) break;
      acknowledged = revision;
      if (revision % 8 == 0 &&
          !(*file)->AppendSnapshot(SnapshotAt(revision), {.commits = 5}).ok()) {
        break;
      }
    }
    (*file)->Abandon();
    return acknowledged;
  }

  void ExpectWhole(const std::string& path, Revision acknowledged, int64_t call) {
    if (ReadFileIfThere(path)->empty()) {
      EXPECT_EQ(acknowledged, 0u);
      return;
    }
    auto file = SceneFile::Open(path, {});
    ASSERT_EQ(file.status(), absl::OkStatus()) << "call " << call;
    const Revision head = (*file)->head().revision;
    EXPECT_GE(head, acknowledged) << "call " << call;
    EXPECT_LE(head, acknowledged + 1) << "call " << call;
    EXPECT_EQ((*file)->StateAt(head).status(), absl::OkStatus());
    EXPECT_EQ((*file)->Append(CommitsBetween(head + 1, head + 1)), absl::OkStatus());
  }

  // Fails the first call, then the second, … until none of them is reached.
  void FailEachCall(FaultyVfs::Call kind, int code) {
    bool has_failed = true;
    for (int64_t call = 0; has_failed; ++call) {
      const std::string path = folder_ / ("scene" + std::to_string(call) + ".db");
      vfs_.FailAfter(call, kind, code);
      const Revision acknowledged = RunUntilFailure(path);
      has_failed = vfs_.failures() > 0;
      vfs_.Heal();
      ExpectWhole(path, acknowledged, call);
      if (!has_failed) {
        EXPECT_EQ(acknowledged, kCommits);
        EXPECT_GT(call, 20) << "as many calls were made to fail";
      }
    }
  }

  static constexpr Revision kCommits = 20;
  TemporaryFolder folder_;
  FaultyVfs vfs_;
};

TEST_F(SceneFileFaultsTest, D05FullAtEachWrite) {
  FailEachCall(FaultyVfs::Call::kWrite, SQLITE_FULL);
}

TEST_F(SceneFileFaultsTest, D06ErrorAtEachSync) {
  FailEachCall(FaultyVfs::Call::kSync, SQLITE_IOERR_FSYNC);
}

TEST_F(SceneFileFaultsTest, D06ErrorAtEachWrite) {
  FailEachCall(FaultyVfs::Call::kWrite, SQLITE_IOERR_WRITE);
}

TEST_F(SceneFileFaultsTest, D05GoesOnWhenThereIsRoomAgain) {
  const std::string path = folder_ / "scene.db";
  auto file = SceneFile::Create(path, StudioIdentity(), {.vfs = vfs_.name()}).value();
  ASSERT_EQ(file->Append(CommitsBetween(1, 3)), absl::OkStatus());
  vfs_.FailAfter(0, FaultyVfs::Call::kWrite, SQLITE_FULL);
  EXPECT_EQ(file->Append(CommitsBetween(4, 4)).code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(file->StateAt(3).value().commits.size(), 3u) << "reading goes on";
  vfs_.Heal();
  EXPECT_EQ(file->Append(CommitsBetween(4, 5)), absl::OkStatus());
  EXPECT_EQ(file->head().revision, 5u);
}

}  // namespace
}  // namespace penumbra::testing
