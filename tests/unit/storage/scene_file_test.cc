#include "server/storage/scene_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "render/scene/field_error.h"
#include "server/storage/database.h"
#include "server/storage/durable_file.h"
#include "tests/support/scene_records.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

class SceneFileTest : public ::testing::Test {
 protected:
  std::unique_ptr<SceneFile> Create() {
    return SceneFile::Create(path_, StudioIdentity(), {}).value();
  }
  // What is on disk at this moment, opened as after a crash: nothing has been closed.
  std::unique_ptr<SceneFile> OpenACopy() {
    const std::string copy = folder_ / "copy.db";
    for (const char* suffix : {"", "-wal"}) {
      const auto bytes = ReadFileIfThere(path_ + suffix);
      EXPECT_EQ(WriteDurably(copy + suffix, *bytes), absl::OkStatus());
    }
    return SceneFile::Open(copy, {}).value();
  }
  // Every snapshot and delta that is kept.
  static std::vector<std::string> BodiesIn(SceneFile& file) {
    std::vector<std::string> bodies;
    for (auto next = file.SnapshotAfter(0).value(); next;) {
      bodies.push_back(next->body);
      next = file.SnapshotAfter(next->revision).value();
    }
    const auto commits = file.CommitsAfter(0, file.head().revision, 1u << 30).value();
    for (const CommitRecord& commit : commits) bodies.push_back(commit.delta);
    return bodies;
  }

  TemporaryFolder folder_;
  const std::string path_ = folder_ / "studio.db";
};

TEST_F(SceneFileTest, ANewFileIsAnEmptyScene) {
  const auto file = Create();
  EXPECT_EQ(file->head().revision, 0u);
  EXPECT_EQ(file->identity().scene_id, "studio");
  const auto state = file->StateAt(0).value();
  EXPECT_FALSE(state.snapshot);
  EXPECT_TRUE(state.commits.empty());
  EXPECT_EQ(file->StateAt(1).status().code(), absl::StatusCode::kOutOfRange);
}

TEST_F(SceneFileTest, WhatIsAppendedIsThereWithoutClosing) {
  const auto file = Create();
  for (Revision revision = 1; revision <= 40; revision += 4) {
    ASSERT_EQ(file->Append(CommitsBetween(revision, revision + 3)), absl::OkStatus());
    const auto copy = OpenACopy();
    EXPECT_EQ(copy->head(), file->head());
    EXPECT_FALSE(copy->had_torn_tail());
    EXPECT_EQ(TextOf(copy->StateAt(revision + 3).value()),
              TextOf({.commits = CommitsBetween(1, revision + 3)}));
  }
}

TEST_F(SceneFileTest, AGapIsNoHistory) {
  const auto file = Create();
  EXPECT_FALSE(file->Append(CommitsBetween(2, 3)).ok());
  EXPECT_EQ(file->head().revision, 0u);
  EXPECT_EQ(file->Append(CommitsBetween(1, 1)), absl::OkStatus());
}

TEST_F(SceneFileTest, ARevisionThatNoColumnHoldsIsRefused) {
  constexpr Revision kLast = std::numeric_limits<int64_t>::max();
  auto file = SceneFile::Create(path_, StudioIdentity(), {}, {.snapshot = SnapshotAt(kLast - 1)});
  ASSERT_EQ(file.status(), absl::OkStatus());
  EXPECT_EQ((*file)->Append(CommitsBetween(kLast, kLast)), absl::OkStatus());
  const std::vector<CommitRecord> next{CommitAt(kLast + 1)};
  EXPECT_EQ(ErrorReason((*file)->Append(next)), "RANGE");
  EXPECT_EQ(OpenACopy()->head().revision, kLast);
  const auto beyond = SceneFile::Create(folder_ / "beyond.db", StudioIdentity(), {},
                                        {.snapshot = SnapshotAt(kLast + 1)});
  EXPECT_EQ(ErrorReason(beyond.status()), "RANGE");
}

TEST_F(SceneFileTest, SnapshotsShortenTheWayAndHistoryStaysLongEnough) {
  const HistoryLimits limits{.commits = 10, .snapshot_after_bytes = 1u << 20, .answers = 5};
  auto file = Create();
  for (Revision revision = 1; revision <= 95; ++revision) {
    ASSERT_EQ(file->Append(CommitsBetween(revision, revision)), absl::OkStatus());
    if (file->is_snapshot_due(limits)) {
      ASSERT_EQ(file->AppendSnapshot(SnapshotAt(revision), limits), absl::OkStatus());
    }
  }
  file.reset();
  file = SceneFile::Open(path_, {}).value();
  EXPECT_EQ(file->head().revision, 95u);
  EXPECT_EQ(file->OldestRevision().value(), 80u) << "the newest snapshot with ten commits after it";
  EXPECT_EQ(TextOf(file->StateAt(95).value()),
            TextOf({.snapshot = SnapshotAt(90), .commits = CommitsBetween(91, 95)}));
  EXPECT_EQ(TextOf(file->StateAt(84).value()),
            TextOf({.snapshot = SnapshotAt(80), .commits = CommitsBetween(81, 84)}));
  const absl::Status compacted = file->StateAt(79).status();
  EXPECT_EQ(compacted.code(), absl::StatusCode::kOutOfRange);
  EXPECT_EQ(ErrorReason(compacted), "COMPACTED");
  EXPECT_EQ(file->History(80).value().size(), 15u);
  EXPECT_EQ(file->History(90).value().front().revision, 91u);
}

TEST_F(SceneFileTest, HistoryIsShorterWhereItWouldTakeTooMuch) {
  const HistoryLimits limits{.commits = 1'000, .bytes = 600};
  const auto file = Create();
  for (Revision revision = 1; revision <= 200; ++revision) {
    ASSERT_EQ(file->Append(CommitsBetween(revision, revision)), absl::OkStatus());
    if (file->is_snapshot_due(limits)) {
      ASSERT_EQ(file->AppendSnapshot(SnapshotAt(revision), limits), absl::OkStatus());
    }
  }
  uint64_t bytes = 0;
  for (const std::string& body : BodiesIn(*file)) bytes += body.size();
  // Until the next snapshot is due it may grow by half, and the newest one is not counted.
  EXPECT_LE(bytes, 600u + 300u + 100u);
  EXPECT_GE(bytes, 200u) << "nor is more given up than has to be";
  const Revision oldest = file->OldestRevision().value();
  EXPECT_GT(oldest, 150u);
  EXPECT_LT(oldest, 200u);
  for (Revision revision = oldest; revision <= 200; ++revision) {
    EXPECT_TRUE(file->StateAt(revision).ok()) << revision;
  }
  EXPECT_EQ(ErrorReason(file->StateAt(oldest - 1).status()), "COMPACTED");
}

TEST_F(SceneFileTest, AnswersOutliveTheirDeltas) {
  const HistoryLimits limits{.commits = 2, .answers = 4};
  auto file = Create();
  ASSERT_EQ(file->Append(CommitsBetween(1, 30)), absl::OkStatus());
  ASSERT_EQ(file->AppendSnapshot(SnapshotAt(30), limits), absl::OkStatus());
  ASSERT_EQ(file->Append(CommitsBetween(31, 33)), absl::OkStatus());
  ASSERT_EQ(file->AppendSnapshot(SnapshotAt(33), limits), absl::OkStatus());
  file = OpenACopy();
  EXPECT_EQ(file->OldestRevision().value(), 30u);
  const auto answers = file->Answers(limits).value();
  ASSERT_EQ(answers.size(), 4u);
  for (size_t i = 0; i < answers.size(); ++i) {
    const CommitRecord expected = CommitAt(24 + 3 * i);
    EXPECT_EQ(answers[i].key, expected.key);
    EXPECT_EQ(answers[i].fingerprint, expected.fingerprint);
    EXPECT_EQ(answers[i].content_hash, expected.content_hash);
    EXPECT_TRUE(answers[i].delta.empty());
  }
}

TEST_F(SceneFileTest, AFileMayBeginInTheMiddle) {
  const SceneState start{.snapshot = SnapshotAt(12),
                         .commits = CommitsBetween(13, 15),
                         .answers = {CommitAt(6), CommitAt(12)}};
  auto file = SceneFile::Create(path_, StudioIdentity(), {}, start).value();
  ASSERT_EQ(file->Append(CommitsBetween(16, 16)), absl::OkStatus());
  file = OpenACopy();
  EXPECT_EQ(file->head().revision, 16u);
  EXPECT_EQ(file->OldestRevision().value(), 12u);
  EXPECT_EQ(file->Answers({}).value().size(), 3u) << "6, 12 and 15";
}

TEST_F(SceneFileTest, AFileMayBeginWithAnswersOlderThanItsSnapshot) {
  const SceneState start{.snapshot = SnapshotAt(13), .answers = {CommitAt(6), CommitAt(12)}};
  auto file = SceneFile::Create(path_, StudioIdentity(), {}, start).value();
  EXPECT_EQ(file->head().revision, 13u);
  ASSERT_EQ(file->Append(CommitsBetween(14, 14)), absl::OkStatus());
  EXPECT_EQ(OpenACopy()->head().revision, 14u);
}

TEST_F(SceneFileTest, TheLogOfAnEarlierFileOfTheNameIsNotReplayed) {
  {
    const auto earlier = Create();
    ASSERT_EQ(earlier->Append(CommitsBetween(1, 5)), absl::OkStatus());
    earlier->Abandon();
  }
  ASSERT_FALSE(ReadFileIfThere(path_ + "-wal")->empty());
  std::filesystem::remove(path_);
  EXPECT_EQ(Create()->head().revision, 0u);
}

TEST_F(SceneFileTest, AFileOfTheFirstFormatIsReadAndBecomesOneOfTheNewest) {
  ASSERT_EQ(Create()->Append(CommitsBetween(1, 5)), absl::OkStatus());
  {
    auto database = Database::Open(path_, {}).value();
    ASSERT_EQ(
        database.Execute("ALTER TABLE scene DROP COLUMN journal; UPDATE scene SET format = 1"),
        absl::OkStatus());
  }
  for (int i = 0; i < 2; ++i) {  // and again as it has become
    auto file = SceneFile::Open(path_, {}).value();
    EXPECT_EQ(file->head().revision, 5u + static_cast<Revision>(i));
    EXPECT_EQ(file->journal(), "");
    ASSERT_EQ(file->Settle(), absl::OkStatus());
    ASSERT_EQ(file->Append(CommitsBetween(6 + i, 6 + i), "a journal"), absl::OkStatus());
    EXPECT_EQ(file->journal(), "a journal");
    ASSERT_EQ(file->Append({}), absl::OkStatus());
    EXPECT_EQ(file->journal(), "");
  }
}

TEST_F(SceneFileTest, TheJournalThatItNamesIsSealed) {
  ASSERT_EQ(Create()->Append(CommitsBetween(1, 5), "a journal"), absl::OkStatus());
  EXPECT_EQ(SceneFile::Open(path_, {}).value()->journal(), "a journal");
  {
    auto database = Database::Open(path_, {}).value();
    ASSERT_EQ(database.Execute("UPDATE scene SET journal = x''"), absl::OkStatus());
  }
  EXPECT_EQ(ErrorReason(SceneFile::Open(path_, {}).status()), "DAMAGED");
}

TEST_F(SceneFileTest, EachSnapshotIsFoundFromBothSides) {
  const auto file = Create();
  ASSERT_EQ(file->Append(CommitsBetween(1, 5)), absl::OkStatus());
  ASSERT_EQ(file->AppendSnapshot(SnapshotAt(5), {}), absl::OkStatus());
  ASSERT_EQ(file->Append(CommitsBetween(6, 8)), absl::OkStatus());
  ASSERT_EQ(file->AppendSnapshot(SnapshotAt(8), {}), absl::OkStatus());
  EXPECT_EQ(BodiesIn(*file).size(), 10u) << "2 snapshots, 8 deltas";
  EXPECT_FALSE(file->SnapshotFor(4).value());
  EXPECT_EQ(file->SnapshotFor(5).value()->revision, 5u);
  EXPECT_EQ(file->SnapshotFor(7).value()->body, SnapshotAt(5).body);
  EXPECT_EQ(file->SnapshotFor(8).value()->revision, 8u);
  EXPECT_EQ(file->SnapshotAfter(5).value()->revision, 8u);
  EXPECT_FALSE(file->SnapshotAfter(8).value());
  EXPECT_EQ(ErrorReason(file->SnapshotFor(9).status()), "FUTURE_BASE");
}

TEST_F(SceneFileTest, TwoCannotHaveIt) {
  const auto file = Create();
  ASSERT_EQ(file->Append(CommitsBetween(1, 1)), absl::OkStatus());
  // SQLite's locks are a process's, so another process has to try.
  const std::string command = "sqlite3 '" + path_ + "' 'SELECT count(*) FROM commits' 2>/dev/null";
  if (std::system("command -v sqlite3 >/dev/null") != 0) GTEST_SKIP() << "no sqlite3 here";
  EXPECT_NE(std::system(command.c_str()), 0);
}

}  // namespace
}  // namespace penumbra::testing
