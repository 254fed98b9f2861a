// A store while one of its scenes still goes to a journal that is full, and another to the next.

#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "render/engine/local_engine.h"
#include "server/scene_store/scene_store.h"
#include "tests/integration/service/studio.h"
#include "tests/support/left_by_kill.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

class TwoJournalsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* id : {"early", "late"}) ASSERT_TRUE(scenes_.Create(id).ok());
  }
  void TearDown() override { storage_->Stop(); }

  // One of each scene, on their way at the same time.
  void Commit(const std::vector<std::string>& ids) {
    SceneDelta delta;
    delta.upsert_lights = {SquareLight(3.0f + static_cast<float>(++commits_))};
    std::vector<std::future<absl::Status>> answers;
    for (const std::string& id : ids) {
      const auto answer = std::make_shared<std::promise<absl::Status>>();
      answers.push_back(answer->get_future());
      scenes_.Commit(id, {.delta = delta}, {},
                     [answer](const auto& outcome) { answer->set_value(outcome.status()); });
    }
    for (auto& answer : answers) ASSERT_EQ(answer.get(), absl::OkStatus());
  }
  // That a kill at this moment leaves in the scene's file; empty: none.
  std::string JournalOf(const std::string& id) {
    const auto file = SceneFileIn(folder_ / "copy", id);
    return file ? file->journal() : std::string();
  }
  void Copy() { LeaveAsByKill(folder_ / "data", folder_ / "copy"); }

  // What a scene that has been deleted since left in the journal, until another takes its place.
  // The early scene is edited meanwhile.
  void FillJournal() {
    const CommitRecord commit{.revision = 1, .delta = std::string(1u << 20, 'x')};
    const JournalEntry entry{.incarnation = std::string(16, 'g'),
                             .chained = {commit, LinkOf(ContentHash(), commit)}};
    const JournalEntries entries = {std::span(&entry, 1)};
    const std::string id = storage_->journals().Current().value()->id();
    for (auto journal = storage_->journals().Current().value(); journal->id() == id;
         journal = storage_->journals().Current().value()) {
      // Nobody else appends: all commits are answered.
      ASSERT_EQ(storage_->journals().Append(*journal, entries), absl::OkStatus());
      ASSERT_NO_FATAL_FAILURE(Commit({"early"}));
    }
  }
  // Whether scenes are in two journals in the copy. The early one may have come to rest before the
  // late one was busy, if the machine is slow.
  bool ComeToBeInTwoJournals() {
    for (int i = 0; i < 20 && JournalOf("early").empty(); ++i) {
      Commit({"early"});
      Commit({"early"});
      Copy();
    }
    FillJournal();
    for (int i = 0; i < 20 && !HasFatalFailure(); ++i) {
      for (int j = 0; j < 3; ++j) Commit({"early", "late"});
      Copy();
      const std::string early = JournalOf("early"), late = JournalOf("late");
      if (!early.empty() && !late.empty() && early != late) return true;
    }
    return false;
  }

  const TemporaryFolder folder_;
  const ServerLimits limits_{.max_commit_delay_ms = 60'000};
  ServerCounters counters_;
  const std::unique_ptr<SceneStorage> storage_ =
      SceneStorage::Open(folder_ / "data", {}, QuietLogger()).value();
  LocalEngine engine_{{.cpu_threads = 1}};
  BlobStore blobs_{limits_};
  SceneStore scenes_{engine_, blobs_, limits_, counters_, storage_.get()};
  int commits_ = 0;
};

TEST_F(TwoJournalsTest, D01CommitsToBothAreThereAfterACrash) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!ComeToBeInTwoJournals()) {
    ASSERT_FALSE(HasFatalFailure());
    ASSERT_LT(std::chrono::steady_clock::now(), end) << "scenes are in one journal, or in none";
  }
  BlobStore blobs(limits_);
  const auto storage = SceneStorage::Open(folder_ / "copy", {}, QuietLogger()).value();
  const auto restored = storage->Restore(blobs, limits_.scene);
  ASSERT_EQ(restored.size(), 2u);
  for (const RestoredScene& one : restored) {
    ASSERT_EQ(one.status, absl::OkStatus()) << one.scene_id;
    const auto acknowledged = scenes_.Snapshot(one.scene_id).value();
    EXPECT_EQ(one.scene->revision(), acknowledged->revision()) << one.scene_id;
    EXPECT_EQ(one.scene->content_hash(), acknowledged->content_hash()) << one.scene_id;
  }
}

}  // namespace
}  // namespace penumbra::testing
