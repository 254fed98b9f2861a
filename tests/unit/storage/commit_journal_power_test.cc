// Row D02 of the catalogue, for journals: power is lost at each call to the disk. Every group that
// was acknowledged is there, and none by halves.

#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <optional>
#include <random>
#include <string>

#include "server/storage/commit_journal.h"
#include "server/storage/durable_file.h"
#include "tests/support/disk_image.h"
#include "tests/support/faulty_vfs.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/storage/journal_groups.h"

namespace penumbra::testing {
namespace {

using Luck = DiskImage::Luck;

constexpr size_t kGroups = 8;

class CommitJournalPowerTest : public ::testing::Test {
 protected:
  // Loses power at every call of a journal's life; `spare`: what its log is written over.
  void LosePowerEverywhere(Luck luck, const std::string& spare) {
    bool has_gone = true;
    int64_t call = 0;
    for (; has_gone; ++call) {
      const std::string path = folder_ / ("journal" + std::to_string(journals_++) + ".db");
      if (!spare.empty()) std::ofstream(folder_ / "spare", std::ios::binary) << spare;
      vfs_.FailAfter(call, FaultyVfs::Call::kAny, SQLITE_IOERR);
      JournalGroups groups;
      const auto acknowledged = Work(path, groups);
      has_gone = vfs_.failures() > 0;
      vfs_.Heal();
      disk_.LosePower(has_gone ? luck : Luck::kEverything, random_);
      vfs_.FailAfter(0, FaultyVfs::Call::kNone, SQLITE_OK);
      if (!acknowledged) continue;  // no scene has heard of it
      ExpectGroups(path, groups, *acknowledged, call);
      EXPECT_TRUE(has_gone || *acknowledged == kGroups) << *acknowledged;
    }
    EXPECT_GT(call, 40) << "as many calls were the last";
  }

  // How many groups were acknowledged; none: there is no journal yet.
  std::optional<size_t> Work(const std::string& path, JournalGroups& groups) {
    auto journal = CommitJournal::Create(path, path, {.vfs = vfs_.name()}, folder_ / "spare");
    if (!journal.ok()) return std::nullopt;
    for (size_t acknowledged = 0; acknowledged < kGroups; ++acknowledged) {
      if (!(*journal)->Append(groups.Next().entries()).ok()) return acknowledged;
    }
    return kGroups;
  }

  static void ExpectGroups(const std::string& path, const JournalGroups& groups,
                           size_t acknowledged, int64_t call) {
    const auto found = ReadJournal(path, {});
    ASSERT_EQ(found.status(), absl::OkStatus()) << "call " << call;
    EXPECT_EQ(found->id, path);
    const Texts texts = TextsOf(*found);
    // The one that was on its way may be there.
    EXPECT_TRUE(texts == groups.After(acknowledged) || texts == groups.After(groups.count()))
        << "call " << call << ", " << acknowledged << " groups acknowledged";
  }

  TemporaryFolder folder_;
  DiskImage disk_;
  FaultyVfs vfs_{&disk_};
  std::mt19937 random_{17};
  int journals_ = 0;
};

TEST_F(CommitJournalPowerTest, D02GroupsThatWereAcknowledgedAreThereAndNoneByHalves) {
  for (const Luck luck : {Luck::kNothing, Luck::kEverything, Luck::kSome, Luck::kSome}) {
    LosePowerEverywhere(luck, /*spare=*/"");
  }
}

// Then old frames lie where new ones have not arrived.
TEST_F(CommitJournalPowerTest, D02SoAreThoseThatAreWrittenOverAnEarlierLog) {
  const std::string path = folder_ / "earlier.db", spare = folder_ / "spare";
  {
    JournalGroups groups;
    auto journal = CommitJournal::Create(path, "earlier", {}).value();
    for (size_t i = 0; i < 2 * kGroups; ++i) {
      ASSERT_EQ(journal->Append(groups.Next().entries()), absl::OkStatus());
    }
  }
  ASSERT_EQ(SpareLog(path, spare), absl::OkStatus());
  const std::string log = *ReadFileIfThere(spare);
  ASSERT_GT(log.size(), 50'000u);
  for (const Luck luck : {Luck::kNothing, Luck::kEverything, Luck::kSome, Luck::kSome}) {
    LosePowerEverywhere(luck, log);
  }
}

}  // namespace
}  // namespace penumbra::testing
