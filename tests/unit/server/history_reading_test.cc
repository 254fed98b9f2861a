// Histories that change, are cut or go while they are read, since nobody waits until they have
// been.
#include "server/scene_store/history_reading.h"

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "render/scene/field_error.h"
#include "server/scene_store/stored_scene.h"
#include "tests/support/faulty_vfs.h"
#include "tests/support/scene_records.h"
#include "tests/support/small_archive.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

// Commits of 40 KB: fewer than 30 of them are read at a time.
constexpr int kLights = 1'000;

// Calls back when the first mesh is looked for, with much of a history still to be read.
class WatchedBlobs final : public BlobSource {
 public:
  explicit WatchedBlobs(std::function<void()> on_first) : on_first_(std::move(on_first)) {}
  std::shared_ptr<const Mesh> FindMesh(const ContentHash&) const override {
    if (auto first = std::exchange(on_first_, nullptr)) first();
    return BoxAndLamp(1).upsert_instances[0].mesh;
  }
  std::shared_ptr<const AlphaMask> FindMask(const ContentHash&) const override { return nullptr; }

 private:
  mutable std::function<void()> on_first_;
};

class HistoryReadingTest : public ::testing::Test {
 protected:
  HistoryReadingTest() {
    const SceneIdentity identity{
        .scene_id = "studio", .incarnation = std::string(16, 'i'), .owner = directory_->identity()};
    auto file =
        SceneFile::Create(directory_->ScenePath("studio", 1), identity, options_.database).value();
    EXPECT_EQ(file->Settle(), absl::OkStatus());
    log_ = std::make_unique<SceneLog>(*directory_, journals_, options_, std::move(file));
  }

  // The box somewhere else, and all lamps.
  CommitRecord Next() {
    SceneDelta delta = BoxAndLamp(static_cast<float>(1 + newest_->revision()));
    for (int i = 0; i < kLights; ++i) {
      delta.upsert_lights.push_back(
          {.id = "lamp-" + std::to_string(i), .shape = PointLight{.position = Vec3(0, 1, i)}});
    }
    newest_ = newest_->Apply(delta).value();
    scenes_[newest_->revision()] = newest_;
    return {.revision = newest_->revision(),
            .content_hash = newest_->content_hash(),
            .author = "tester",
            .delta = ToProto(delta).SerializeAsString()};
  }
  absl::Status Commit(int count = 1) {
    const auto before = newest_;
    std::vector<CommitRecord> commits;
    for (int i = 0; i < count; ++i) commits.push_back(Next());
    return log_->Append(commits, [&] { return SceneState{.snapshot = SnapshotOf(*before)}; });
  }
  void CommitMany(int count) { ASSERT_EQ(Commit(count), absl::OkStatus()); }
  // Puts a commit into the journal that the file names, and leaves it to the test to tell the log.
  std::vector<JournalEntry> WriteToJournal() {
    auto entered = log_->EnterJournal({Next()});
    EXPECT_TRUE(entered);
    if (!entered) return {};
    EXPECT_EQ(journals_.Append(*entered->journal, {entered->entries}), absl::OkStatus());
    return std::move(entered->entries);
  }
  // Forgets what is more than 40 commits older than the newest snapshot but one.
  void Compact() {
    ASSERT_EQ(log_->Tidy([this] { return SnapshotOf(*newest_); }), absl::OkStatus());
  }
  absl::StatusOr<std::shared_ptr<const Scene>> Past(Revision revision,
                                                    std::function<void()> on_first = nullptr) {
    return PastScene(*log_, revision, WatchedBlobs(std::move(on_first)), {});
  }

  const TemporaryFolder folder_;
  FaultyVfs disk_;
  const SceneLogOptions options_{
      .history = {.commits = 40, .snapshot_after_bytes = 1u << 30},
      .database = {.vfs = disk_.name()},
  };
  const std::unique_ptr<DataDirectory> directory_ = DataDirectory::Open(folder_ / "data").value();
  SharedJournal journals_{*directory_, options_.database, QuietLogger()};
  std::unique_ptr<SceneLog> log_;
  std::shared_ptr<const Scene> newest_ = Scene::Empty("studio");
  std::map<Revision, std::shared_ptr<const Scene>> scenes_;
};

TEST_F(HistoryReadingTest, APastSceneIsMadeOfSnapshotAndCommits) {
  CommitMany(60);
  Compact();
  CommitMany(60);
  for (const Revision revision : {1, 59, 60, 61, 120}) {
    const auto scene = Past(revision);
    ASSERT_TRUE(scene.ok()) << scene.status();
    EXPECT_EQ((*scene)->revision(), revision);
    EXPECT_EQ((*scene)->content_hash(), scenes_.at(revision)->content_hash()) << revision;
  }
  EXPECT_TRUE(Past(0).value()->lights().empty());
  EXPECT_EQ(ErrorReason(Past(121).status()), "FUTURE_BASE");
}

TEST_F(HistoryReadingTest, CommitsComeBetweenThePiecesOfAPastScene) {
  CommitMany(80);
  absl::Status committed = absl::UnknownError("not asked");
  const auto scene = Past(80, [&] { committed = Commit(); });
  EXPECT_EQ(committed, absl::OkStatus());
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ((*scene)->content_hash(), scenes_.at(80)->content_hash());
  // So what has not been read then is not read at all.
  const auto removed = Past(80, [&] { ASSERT_EQ(log_->Remove(), absl::OkStatus()); });
  EXPECT_EQ(ErrorReason(removed.status()), "UNKNOWN_ID") << removed.status();
}

TEST_F(HistoryReadingTest, WhatIsForgottenMeanwhileIsMadeOfWhatIsKept) {
  for (const bool is_kept : {true, false}) {
    const Revision first = newest_->revision();
    CommitMany(100);
    const auto scene = Past(first + (is_kept ? 100 : 60), [&] {
      Compact();
      CommitMany(50);
      Compact();
    });
    if (is_kept) {
      ASSERT_TRUE(scene.ok()) << scene.status();
      EXPECT_EQ((*scene)->content_hash(), scenes_.at(first + 100)->content_hash());
    } else {
      EXPECT_EQ(ErrorReason(scene.status()), "COMPACTED") << scene.status();
    }
  }
}

TEST_F(HistoryReadingTest, CommitsComeBetweenThePiecesThatAreVisited) {
  CommitMany(45);
  Compact();
  CommitMany(45);
  size_t visited = 0;
  std::future<absl::Status> commit;
  const absl::Status status = ForEachBody(*log_, [&](std::string_view body) {
    EXPECT_GT(body.size(), 30'000u);
    if (++visited == 5) {
      commit = std::async(std::launch::async, [&] { return Commit(); });
      EXPECT_EQ(commit.wait_for(std::chrono::seconds(10)), std::future_status::ready);
    }
    return absl::OkStatus();
  });
  EXPECT_EQ(status, absl::OkStatus());
  EXPECT_EQ(commit.get(), absl::OkStatus());
  EXPECT_EQ(visited, 92u) << "a snapshot, 90 deltas, and the one that came";
}

// Whoever has written for many scenes tells one after another.
TEST_F(HistoryReadingTest, WhatIsInTheJournalIsToldWhileAHistoryIsReadAndIsReadNext) {
  for (int i = 0; i < 100 && !log_->is_in_journal(); ++i) CommitMany(1);
  log_->LeaveJournal(WriteToJournal(), /*were_written=*/true);
  auto entries = WriteToJournal();
  const auto read = [this] { return log_->CommitsAfter(0, newest_->revision(), 1u << 30); };
  disk_.Stall();
  auto reading = std::async(std::launch::async, read);
  // Until it waits for the disk: the file takes over what the journal had before.
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  auto telling = std::async(std::launch::async, [&] {
    log_->LeaveJournal(std::move(entries), /*were_written=*/true);
    return log_->is_tidying_due();
  });
  EXPECT_EQ(telling.wait_for(std::chrono::seconds(10)), std::future_status::ready);
  EXPECT_EQ(reading.wait_for(std::chrono::seconds(0)), std::future_status::timeout);
  disk_.Heal();
  telling.get();
  const auto first = reading.get();
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_EQ(first->back().revision, newest_->revision() - 1);
  const auto second = read();
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_EQ(second->back().revision, newest_->revision());
  CommitMany(1);
}

TEST_F(HistoryReadingTest, NothingIsForgottenWhileItIsVisited) {
  CommitMany(45);
  Compact();
  CommitMany(45);
  size_t visited = 0;
  const auto visit = [&](std::string_view) {
    if (++visited == 1) Compact();
    return absl::OkStatus();
  };
  EXPECT_EQ(ForEachBody(*log_, visit), absl::OkStatus());
  EXPECT_EQ(visited, 91u);
  Compact();
  visited = 1;
  EXPECT_EQ(ForEachBody(*log_, visit), absl::OkStatus());
  EXPECT_EQ(visited - 1, 47u) << "two snapshots, and the deltas between them";
}

TEST_F(HistoryReadingTest, AHistoryThatIsBegunAnewMeanwhileIsNotWholeAndARemovedOneNeedsNothing) {
  CommitMany(45);
  size_t visited = 0;
  const auto when_third = [&](const std::function<void()>& then) {
    visited = 0;
    return [&visited, then](std::string_view) {
      if (++visited == 3) then();
      return absl::OkStatus();
    };
  };
  const absl::Status begun_anew = ForEachBody(*log_, when_third([&] {
    disk_.FailAfter(0, FaultyVfs::Call::kSync, SQLITE_IOERR_FSYNC);
    const auto before = newest_;
    EXPECT_EQ(Commit().code(), absl::StatusCode::kUnavailable);
    disk_.Heal();
    newest_ = before;
    EXPECT_EQ(Commit(), absl::OkStatus());
  }));
  EXPECT_EQ(begun_anew.code(), absl::StatusCode::kAborted) << begun_anew;
  CommitMany(45);
  const absl::Status removed =
      ForEachBody(*log_, when_third([&] { log_->Remove().IgnoreError(); }));
  EXPECT_EQ(removed, absl::OkStatus());
  EXPECT_EQ(ForEachBody(*log_, when_third([] {})), absl::OkStatus());
  EXPECT_EQ(visited, 0u);
}

}  // namespace
}  // namespace penumbra::testing
