// Which job runs, which is cancelled, and what subscribers get: told step by step, without a clock.
#include <atomic>
#include <chrono>
#include <thread>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "render/engine/local_engine.h"
#include "tests/unit/engine/scripted_technique.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;

class SchedulingTest : public ::testing::Test {
 protected:
  SchedulingTest() {
    EXPECT_TRUE(engine_.CreateScene("s").ok());
    Commit(LampAndFloor());
  }
  Revision Commit(const SceneDelta& delta) { return engine_.Commit("s", delta).value(); }
  std::unique_ptr<Subscription> Subscribe(UpdateLog& log, uint64_t seed = 1) {
    return engine_.Subscribe("s", LampOnFloor(seed), log.Callback()).value();
  }

  ScriptedTechnique technique_;
  UpdateLog log_;
  LocalEngine engine_{OptionsFor(technique_)};
};

TEST_F(SchedulingTest, CoarsePassesThenTheFinalOne) {
  const auto subscription = Subscribe(log_);
  technique_.Pass();
  log_.AwaitCount(1);
  technique_.Pass();
  log_.AwaitCount(2);
  technique_.Finish();
  const auto updates = log_.AwaitCount(3);
  for (uint32_t i = 0; i < 3; ++i) {
    EXPECT_EQ(updates[i].revision, 1u);
    EXPECT_EQ(updates[i].artifact->header.pass, i);
    EXPECT_EQ(updates[i].artifact->header.is_final, i == 2);
  }
}

TEST_F(SchedulingTest, OneJobForAllWhoAskTheSame) {
  UpdateLog second, third;
  const auto a = Subscribe(log_);
  const auto b = Subscribe(second);
  technique_.Finish();
  const auto mine = log_.AwaitFinalAt(1);
  const auto theirs = second.AwaitFinalAt(1);
  EXPECT_EQ(mine.back().artifact, theirs.back().artifact) << "the same object";
  const auto c = Subscribe(third);
  EXPECT_EQ(third.AwaitCount(1)[0].artifact, mine.back().artifact) << "who comes late, at once";
  EXPECT_EQ(engine_.statistics().jobs_started, 1u);
  EXPECT_EQ(engine_.statistics().artifacts_published, 1u);

  UpdateLog other;
  const auto d = Subscribe(other, /*seed=*/2);
  technique_.Finish();
  EXPECT_NE(other.AwaitFinalAt(1).back().artifact, mine.back().artifact);
  EXPECT_EQ(engine_.statistics().jobs_started, 2u);
}

TEST_F(SchedulingTest, ACommitStopsTheJobThatHasShownItsFirstPass) {
  const auto subscription = Subscribe(log_);
  technique_.Pass();
  log_.AwaitCount(1);
  const auto job = technique_.AwaitJob(0);
  EXPECT_FALSE(job.stop.stop_requested());
  Commit(BoxAt(0.1f));
  EXPECT_TRUE(job.stop.stop_requested());
  EXPECT_EQ(technique_.AwaitJob(1).revision, 2u);
  technique_.Finish();
  EXPECT_EQ(log_.AwaitFinalAt(2).size(), 2u);
  EXPECT_EQ(engine_.statistics().jobs_cancelled, 1u);
  EXPECT_EQ(engine_.statistics().jobs_finished, 1u);
}

TEST_F(SchedulingTest, OneThatHasNotMayFirstShowItAsOfItsOwnRevision) {
  const auto subscription = Subscribe(log_);
  const auto job = technique_.AwaitJob(0);
  Commit(BoxAt(0.1f));
  Commit(BoxAt(0.2f));
  EXPECT_FALSE(job.stop.stop_requested());
  technique_.Pass();
  EXPECT_TRUE(job.stop.stop_requested());
  const auto updates = log_.AwaitCount(1);
  EXPECT_EQ(updates[0].revision, 1u) << "never passed off as the newest";
  EXPECT_EQ(technique_.AwaitJob(1).revision, 3u) << "the revision between is left out";
}

TEST_F(SchedulingTest, CommitsThatNeverEndStillShow) {
  const auto subscription = Subscribe(log_);
  constexpr int kCommits = 50;
  for (int i = 0; i < kCommits; ++i) {
    technique_.AwaitJob(i);
    Commit(BoxAt(0.001f * (i + 1)));  // before the job has shown anything
    technique_.Pass();
    log_.AwaitCount(i + 1);
  }
  technique_.AwaitJob(kCommits);
  technique_.Finish();
  const auto updates = log_.AwaitFinalAt(1 + kCommits);
  ASSERT_EQ(updates.size(), 1u + kCommits);
  for (int i = 0; i <= kCommits; ++i) EXPECT_EQ(updates[i].revision, 1u + i);
  EXPECT_EQ(engine_.statistics().jobs_cancelled, uint64_t{kCommits});
  EXPECT_EQ(engine_.statistics().first_passes, 1u + kCommits);
}

TEST_F(SchedulingTest, AJobThatEndsBeforeItNoticesIsNotShownTwice) {
  const auto subscription = Subscribe(log_);
  technique_.AwaitJob(0);
  Commit(BoxAt(0.1f));
  technique_.Finish();  // final at once, without a coarse pass: the only thing there is to show
  EXPECT_TRUE(IsFinalAt(log_.AwaitCount(1)[0], 1));
  technique_.AwaitJob(1);
  technique_.Finish();
  EXPECT_EQ(log_.AwaitFinalAt(2).size(), 2u);
}

TEST_F(SchedulingTest, ACommitOutOfTheWayReachesSubscribersWithoutAJob) {
  const auto subscription = Subscribe(log_);
  technique_.Finish();
  const auto before = log_.AwaitFinalAt(1);
  Instance far = *engine_.Snapshot("s").value()->FindInstance("box");
  far.id = "far";
  far.world_from_mesh[3] = Vec3(10, 1, 0);
  Commit({.upsert_instances = {far}});
  const auto after = log_.AwaitFinalAt(2);
  EXPECT_EQ(after.back().artifact, before.back().artifact);
  EXPECT_EQ(engine_.statistics().jobs_started, 1u);
  EXPECT_EQ(engine_.statistics().unaffected_commits, 1u);
}

TEST_F(SchedulingTest, ACommitOutOfTheWayLetsTheJobRunOn) {
  const auto subscription = Subscribe(log_);
  const auto job = technique_.AwaitJob(0);
  Commit({.upsert_lights = {{"other", PointLight{}}}});
  technique_.Pass();
  EXPECT_EQ(log_.AwaitCount(1)[0].revision, 2u);
  Commit({.remove_lights = {"other"}});
  EXPECT_EQ(log_.AwaitCount(2)[1].revision, 3u);
  EXPECT_FALSE(job.stop.stop_requested());
  technique_.Finish();
  EXPECT_TRUE(IsFinalAt(log_.AwaitCount(3)[2], 3));
  EXPECT_EQ(engine_.statistics().jobs_started, 1u);
}

TEST_F(SchedulingTest, C16WhoLeavesLastCancelsTheJob) {
  UpdateLog second;
  auto a = Subscribe(log_);
  auto b = Subscribe(second);
  const auto job = technique_.AwaitJob(0);
  a.reset();
  EXPECT_FALSE(job.stop.stop_requested());
  b.reset();
  EXPECT_TRUE(job.stop.stop_requested());
  technique_.AwaitEnd(0);
  const auto again = Subscribe(log_);
  technique_.AwaitJob(1);
  technique_.Finish();
  log_.AwaitFinalAt(1);
}

TEST_F(SchedulingTest, AnErrorIsSaidAndACommitMendsIt) {
  Commit({.remove_lights = {"lamp"}});
  const auto subscription = Subscribe(log_);
  const ArtifactUpdate missing = log_.AwaitCount(1)[0];
  EXPECT_EQ(missing.status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(missing.status.message()), HasSubstr("no such light"));
  EXPECT_EQ(missing.artifact, nullptr);
  EXPECT_EQ(missing.revision, 2u);
  Commit({.upsert_lights = {{"lamp", PointLight{.position = Vec3(0, 2, 0)}}}});
  technique_.Finish();
  log_.AwaitFinalAt(3);
}

TEST_F(SchedulingTest, ErrorsOfTheTechniqueAndExceptionsArrive) {
  const auto subscription = Subscribe(log_);
  technique_.Fail(absl::ResourceExhaustedError("too much"));
  EXPECT_EQ(log_.AwaitCount(1)[0].status.code(), absl::StatusCode::kResourceExhausted);
  Commit({.remove_instances = {"box"}});
  technique_.AwaitJob(1);
  technique_.Throw();
  const auto updates = log_.AwaitLast([](const auto& update) { return update.revision == 2; });
  EXPECT_EQ(updates.back().status.code(), absl::StatusCode::kInternal);
  EXPECT_THAT(std::string(updates.back().status.message()), HasSubstr("thrown by the test"));
  EXPECT_EQ(engine_.statistics().jobs_failed, 2u);
}

TEST_F(SchedulingTest, ACommitDuringAJobThatFailsMayMendIt) {
  const auto subscription = Subscribe(log_);
  technique_.AwaitJob(0);
  Commit({.upsert_lights = {{"other", PointLight{}}}});  // does not touch the artifact
  technique_.Fail(absl::ResourceExhaustedError("too much"));
  technique_.AwaitJob(1);
  technique_.Finish();
  log_.AwaitFinalAt(2);
}

TEST_F(SchedulingTest, DeletingTheSceneIsTheLastWord) {
  const auto subscription = Subscribe(log_);
  const auto job = technique_.AwaitJob(0);
  ASSERT_TRUE(engine_.DeleteScene("s").ok());
  EXPECT_TRUE(job.stop.stop_requested());
  const auto updates = log_.AwaitCount(1);
  EXPECT_EQ(updates.back().status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(updates.back().status.message()), HasSubstr("'s', which was deleted"));
  ASSERT_TRUE(engine_.CreateScene("s").ok());
  Commit(LampAndFloor());
  technique_.AwaitEnd(0);
  EXPECT_EQ(log_.all().size(), 1u) << "another scene of that name is another scene";
}

// A technique that takes a while, and commits that come every 5 ms for longer than it takes.
TEST(SteadyCommitsTest, At200HzUpdatesComeAndTheLastRevisionIsFinished) {
  constexpr int kPasses = 8;
  const FunctionTechnique slow([](const Scene& scene, const ArtifactSpec&,
                                  const ComputeContext& context) -> absl::StatusOr<Artifact> {
    for (uint32_t pass = 0; pass < kPasses; ++pass) {
      std::this_thread::sleep_for(std::chrono::milliseconds(7));
      if (context.stop.stop_requested()) return absl::CancelledError("stopped");
      context.progress(LabelledArtifact(scene, pass, false));
    }
    return LabelledArtifact(scene, kPasses, true);
  });
  UpdateLog log;
  LocalEngine engine(OptionsFor(slow));
  ASSERT_TRUE(engine.CreateScene("s").ok());
  ASSERT_TRUE(engine.Commit("s", LampAndFloor()).ok());
  const auto subscription = engine.Subscribe("s", LampOnFloor(), log.Callback()).value();
  Revision last = 0;
  constexpr int kCommits = 200;
  for (int i = 0; i < kCommits; ++i) {
    last = engine.Commit("s", BoxAt(0.001f * (i + 1))).value();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const size_t during = log.all().size();
  const auto updates = log.AwaitFinalAt(last);
  EXPECT_GE(during, 20u) << "about 1 s of commits, 7 ms to a first pass";
  for (size_t i = 1; i < updates.size(); ++i) {
    EXPECT_LE(updates[i - 1].revision, updates[i].revision);
  }
}

}  // namespace
}  // namespace penumbra::testing
