// A journal tells what was written to it, or that it is not whole. Rows D03 to D06.

#include "server/storage/commit_journal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "server/storage/durable_file.h"
#include "tests/support/faulty_vfs.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/storage/journal_groups.h"

namespace penumbra::testing {
namespace {

constexpr char kId[] = "0123456789abcdef";

// Whether `found` is what the beginning of `written` was at some time.
bool IsBeginning(const Texts& found, const Texts& written) {
  return std::all_of(found.begin(), found.end(), [&](const auto& scene) {
    const auto whole = written.find(scene.first);
    return whole != written.end() && scene.second.size() <= whole->second.size() &&
           std::equal(scene.second.begin(), scene.second.end(), whole->second.begin());
  });
}

class CommitJournalTest : public ::testing::Test {
 protected:
  // Ten groups; how long the log was before them, and after each.
  std::vector<uintmax_t> Write() {
    auto journal = CommitJournal::Create(path_, kId, {}).value();
    const auto length = [this] { return std::filesystem::file_size(path_ + "-wal"); };
    std::vector<uintmax_t> lengths = {length()};
    for (int i = 0; i < 10; ++i) {
      const auto group = groups_.Next();
      EXPECT_EQ(journal->Append(group.entries()), absl::OkStatus());
      lengths.push_back(length());
    }
    journal.reset();
    Copy();
    return lengths;
  }
  void Copy() {
    for (const char* suffix : {"", "-wal"}) {
      std::filesystem::copy_file(path_ + suffix, copy_ + suffix,
                                 std::filesystem::copy_options::overwrite_existing);
    }
  }

  TemporaryFolder folder_;
  JournalGroups groups_;
  const std::string path_ = folder_ / "1.db";
  const std::string copy_ = folder_ / "2.db";
};

TEST_F(CommitJournalTest, TellsEachScenesCommitsInTheirOrder) {
  Write();
  const FoundJournal found = ReadJournal(copy_, {}).value();
  EXPECT_EQ(found.id, kId);
  EXPECT_EQ(TextsOf(found), groups_.After(10));
  EXPECT_EQ(found.commits.at("ada").size(), 19u);
  EXPECT_EQ(found.commits.at("bob").size(), 20u);
}

TEST_F(CommitJournalTest, TheLogOfAnEarlierOneIsWrittenOver) {
  Write();
  const std::string spare = folder_ / "spare", path = folder_ / "3.db", copy = folder_ / "4.db";
  const size_t length = ReadFileIfThere(path_ + "-wal")->size();
  ASSERT_EQ(SpareLog(path_, spare), absl::OkStatus());
  EXPECT_TRUE(ReadFileIfThere(path_)->empty());
  auto journal = CommitJournal::Create(path, "another", {}, spare).value();
  EXPECT_TRUE(ReadFileIfThere(spare)->empty());
  EXPECT_EQ(ReadFileIfThere(path + "-wal")->size(), length);
  // Nothing of the earlier one is found, at any time.
  for (const char* suffix : {"", "-wal"}) std::filesystem::copy_file(path + suffix, copy + suffix);
  EXPECT_TRUE(ReadJournal(copy, {}).value().commits.empty());
  Chain ada("ada");
  const auto entries = ada.Next(2);
  ASSERT_EQ(journal->Append({entries}), absl::OkStatus());
  journal.reset();
  const FoundJournal found = ReadJournal(path, {}).value();
  EXPECT_EQ(found.id, "another");
  ASSERT_EQ(found.commits.size(), 1u);
  EXPECT_EQ(found.commits.at("ada").size(), 2u);
  EXPECT_EQ(ReadFileIfThere(path + "-wal")->size(), length) << "it has not grown";
}

TEST_F(CommitJournalTest, D04FlippedBitsAreNoticedOrTakeAwayItsEnd) {
  Write();
  const Texts& written = groups_.After(10);
  std::minstd_rand random(5);
  int damaged = 0, shorter = 0;
  for (int i = 0; i < 2'000; ++i) {
    const std::string suffix = i % 4 == 0 ? "" : "-wal";
    std::string flipped = *ReadFileIfThere(path_ + suffix);
    flipped[random() % flipped.size()] ^= static_cast<char>(1 << random() % 8);
    Copy();
    std::ofstream(copy_ + suffix, std::ios::binary) << flipped;
    const auto found = ReadJournal(copy_, {});
    if (!found.ok()) {
      EXPECT_EQ(found.status().code(), absl::StatusCode::kDataLoss) << found.status();
      ++damaged;
      continue;
    }
    Texts texts = TextsOf(*found);
    EXPECT_TRUE(IsBeginning(texts, written)) << "bit " << i;
    EXPECT_GE(texts["ada"].size() + texts["bob"].size(), 19u + 20u - 3u) << "the last group only";
    shorter += TextsOf(*found) != written;
  }
  EXPECT_GT(damaged, 1'000);
  EXPECT_LT(shorter, 400);
}

// All that is whole in what is left, and nothing of the group that the cut goes through.
TEST_F(CommitJournalTest, D03ACutEndIsItsEndOnly) {
  const std::vector<uintmax_t> lengths = Write();
  const std::string log = *ReadFileIfThere(path_ + "-wal");
  ASSERT_EQ(log.size(), lengths.back());
  std::set<size_t> cuts(lengths.begin(), lengths.end());
  for (size_t length = 0; length < log.size(); length += 1 + log.size() / 500) cuts.insert(length);
  for (const size_t length : cuts) {
    std::filesystem::copy_file(path_, copy_, std::filesystem::copy_options::overwrite_existing);
    std::ofstream(copy_ + "-wal", std::ios::binary) << log.substr(0, length);
    const auto found = ReadJournal(copy_, {});
    ASSERT_EQ(found.status(), absl::OkStatus()) << length;
    const auto whole = std::count_if(lengths.begin() + 1, lengths.end(),
                                     [&](uintmax_t end) { return end <= length; });
    EXPECT_EQ(TextsOf(*found), groups_.After(static_cast<size_t>(whole))) << length;
  }
}

class CommitJournalFaultsTest : public CommitJournalTest {
 protected:
  // Appends until it fails; how many were acknowledged.
  int RunUntilFailure(const std::string& path) {
    auto journal = CommitJournal::Create(path, kId, {.vfs = vfs_.name()});
    if (!journal.ok()) return 0;
    Chain ada("ada");
    for (int i = 0; i < 20; ++i) {
      const auto entries = ada.Next(1);
      if (!(*journal)->Append({entries}).ok()) return i;
    }
    return 20;
  }

  void FailEachCall(FaultyVfs::Call kind, int code) {
    bool has_failed = true;
    int64_t call = 0;
    for (; has_failed; ++call) {
      const std::string path = folder_ / ("journal" + std::to_string(call) + ".db");
      vfs_.FailAfter(call, kind, code);
      const int acknowledged = RunUntilFailure(path);
      has_failed = vfs_.failures() > 0;
      vfs_.Heal();
      if (ReadFileIfThere(path)->empty()) {
        EXPECT_EQ(acknowledged, 0) << "call " << call;
        continue;
      }
      auto found = ReadJournal(path, {});
      ASSERT_EQ(found.status(), absl::OkStatus()) << "call " << call;
      const int there = static_cast<int>(found->commits["ada"].size());
      EXPECT_GE(there, acknowledged) << "call " << call;
      EXPECT_LE(there, acknowledged + 1) << "call " << call;
    }
    EXPECT_GT(call, 20) << "as many calls were made to fail";
  }

  FaultyVfs vfs_;
};

TEST_F(CommitJournalFaultsTest, D05FullAtEachWrite) {
  FailEachCall(FaultyVfs::Call::kWrite, SQLITE_FULL);
}

TEST_F(CommitJournalFaultsTest, D06ErrorAtEachSync) {
  FailEachCall(FaultyVfs::Call::kSync, SQLITE_IOERR_FSYNC);
}

}  // namespace
}  // namespace penumbra::testing
