// Which journals a start leaves where it refuses a scene. Row D04.
#include "server/scene_store/found_journals.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>

#include "server/scene_store/scene_storage.h"
#include "server/scene_store/stored_scene.h"
#include "server/storage/durable_file.h"
#include "tests/support/left_by_kill.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/server/logged_scenes.h"

namespace penumbra::testing {
namespace {

namespace fs = std::filesystem;

class FoundJournalsTest : public ::testing::Test {
 protected:
  // What a kill leaves of "ada", whose file names a journal with so many commits of it.
  void Leave(int journalled) {
    for (const char* data : {"live", "data"}) fs::remove_all(folder_ / data);
    LoggedScenes::Make(folder_ / "live", {"ada"});
    LoggedScenes scenes(folder_ / "live", {});
    ASSERT_EQ(scenes.Open(), absl::OkStatus());
    ASSERT_EQ(scenes.MakeBusy("ada"), absl::OkStatus());
    for (int i = 0; i < journalled; ++i) {
      ASSERT_EQ(scenes.CommitTogether({"ada"}).journals.size(), 1u);
    }
    acknowledged_ = scenes.acknowledged();
    fs::copy(folder_ / "live", folder_ / "data", fs::copy_options::recursive);
    own_ = SceneFileIn(folder_ / "data", "ada")->identity();
    KnownHeads heads;
    heads["ada"] = {.incarnation = own_.incarnation, .revision = newest()};
    ASSERT_EQ(WriteHeads(folder_ / "data/heads", heads), absl::OkStatus());
  }
  Revision newest() const { return acknowledged_.at("ada"); }

  std::string Journal(int number) {
    return folder_ / ("data/journals/" + std::to_string(number) + ".db");
  }
  std::string File() { return folder_ / "data/scenes/ada~1.db"; }
  void TakeAway() { Move(File(), folder_ / "own.db"); }
  // Where the scene's own file was.
  void PutInItsPlace(const SceneIdentity& identity, Revision revision) {
    const auto file = SceneFile::Create(File(), identity, {},
                                        {.snapshot = SnapshotOf(*LampScene("ada", revision))});
    ASSERT_EQ(file.status(), absl::OkStatus());
  }
  static void Move(const std::string& from, const std::string& to) {
    for (const char* suffix : {"", "-wal"}) fs::rename(from + suffix, to + suffix);
  }
  static void FlipBitOf(const std::string& path) {
    std::string bytes = ReadFileIfThere(path).value();
    bytes[bytes.size() / 3] ^= 1;
    ASSERT_EQ(WriteDurably(path, bytes), absl::OkStatus());
  }

  // What a server that starts, and ends, says of the scene.
  absl::Status Start() {
    const ServerLimits limits;
    BlobStore blobs(limits);
    const auto storage = SceneStorage::Open(folder_ / "data", {}, QuietLogger()).value();
    const auto restored = storage->Restore(blobs, limits.scene);
    storage->Stop();
    EXPECT_EQ(restored.size(), 1u);
    return restored.empty() ? absl::NotFoundError("no scene") : restored[0].status;
  }
  void ExpectRefused(const std::string& part) {
    const absl::Status refused = Start();
    EXPECT_EQ(refused.code(), absl::StatusCode::kDataLoss);
    EXPECT_THAT(refused.message(), ::testing::HasSubstr(part));
  }
  void ExpectWholeOnceItsFileIsBack() {
    Move(folder_ / "own.db", File());
    ExpectRestored(folder_ / "data", {}, acknowledged_, /*later=*/0, "with its own file");
  }

  const TemporaryFolder folder_;
  std::map<std::string, Revision> acknowledged_;
  SceneIdentity own_;
};

TEST_F(FoundJournalsTest, D04AnEarlierScenesFileInItsPlaceCostsASceneNothing) {
  for (const int journalled : {0, 5}) {
    SCOPED_TRACE(journalled);
    ASSERT_NO_FATAL_FAILURE(Leave(journalled));
    TakeAway();
    SceneIdentity earlier = own_;
    earlier.incarnation = std::string(16, 'e');
    ASSERT_NO_FATAL_FAILURE(PutInItsPlace(earlier, newest() + 100));
    ExpectRefused("the file of an earlier scene of this id");
    ExpectWholeOnceItsFileIsBack();
  }
}

TEST_F(FoundJournalsTest, D04AnOlderFileInItsPlaceCostsASceneNothing) {
  for (const int journalled : {0, 5}) {
    SCOPED_TRACE(journalled);
    ASSERT_NO_FATAL_FAILURE(Leave(journalled));
    TakeAway();
    ASSERT_NO_FATAL_FAILURE(PutInItsPlace(own_, 1));
    ExpectRefused("revision 1, where " + std::to_string(newest()) + " was on disk");
    ExpectWholeOnceItsFileIsBack();
  }
}

TEST_F(FoundJournalsTest, D04AMissingFileCostsASceneNothingOnceItIsBack) {
  for (const int journalled : {0, 5}) {
    SCOPED_TRACE(journalled);
    ASSERT_NO_FATAL_FAILURE(Leave(journalled));
    TakeAway();
    ExpectRefused("no file, where revision " + std::to_string(newest()) + " was on disk");
    ExpectWholeOnceItsFileIsBack();
  }
}

// As while another process reads it.
TEST_F(FoundJournalsTest, D04ACopyOfADamagedJournalThatCannotBeReadForNowIsKept) {
  ASSERT_NO_FATAL_FAILURE(Leave(5));
  for (const char* suffix : {"", "-wal"}) fs::copy_file(Journal(1) + suffix, Journal(2) + suffix);
  ASSERT_NO_FATAL_FAILURE(FlipBitOf(Journal(1) + "-wal"));
  {
    auto reader = Database::Open(Journal(2), {});
    ASSERT_EQ(reader.status(), absl::OkStatus());
    ASSERT_EQ(reader->Check(), absl::OkStatus());  // has it to itself from here on
    ASSERT_EQ(ReadJournal(Journal(2), {}).status().code(), absl::StatusCode::kUnavailable);
    ExpectRefused("a journal that is damaged or gone");
  }
  ExpectRestored(folder_ / "data", {}, acknowledged_, /*later=*/0, "with the copy");
}

}  // namespace
}  // namespace penumbra::testing
