// What an observer is told of jobs, by a clock that the test sets.
#include <atomic>
#include <mutex>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "render/engine/local_engine.h"
#include "tests/unit/engine/scripted_technique.h"

namespace penumbra::testing {
namespace {

using ::testing::Optional;

class JobReportTest : public ::testing::Test {
 protected:
  JobReportTest() {
    EXPECT_TRUE(engine_.CreateScene("s").ok());
    EXPECT_TRUE(engine_.Commit("s", LampAndFloor()).ok());
  }

  LocalEngineOptions Options() {
    LocalEngineOptions options = OptionsFor(technique_);
    options.runner_threads = 1;
    options.now_ms = [this] { return now_ms_.load(); };
    options.on_job = [this](const JobReport& report) {
      std::lock_guard lock(mutex_);
      reports_.push_back(report);
      changed_.notify_all();
    };
    return options;
  }

  std::unique_ptr<Subscription> Subscribe(uint64_t seed = 1) {
    return engine_.Subscribe("s", LampOnFloor(seed), log_.Callback()).value();
  }

  JobReport AwaitReport(size_t index) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return reports_.size() > index; });
    return reports_[index];
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<JobReport> reports_;
  std::atomic<double> now_ms_ = 1000;
  ScriptedTechnique technique_;
  UpdateLog log_;
  LocalEngine engine_{Options()};
};

TEST_F(JobReportTest, TimesAreFromTheSubscriptionToTheFirstAndTheFinalArtifact) {
  const auto first = Subscribe(1);
  technique_.AwaitJob(0);
  const auto second = Subscribe(2);  // waits for the only runner
  now_ms_ = 1010;
  technique_.Pass();
  now_ms_ = 1030;
  technique_.Finish();
  const JobReport report = AwaitReport(0);
  EXPECT_EQ(report.technique, "soft_texture");
  EXPECT_EQ(report.outcome, JobReport::Outcome::kFinished);
  EXPECT_EQ(report.waited_ms, 0);
  EXPECT_EQ(report.computed_ms, 30);
  EXPECT_THAT(report.first_artifact_ms, Optional(10));
  EXPECT_THAT(report.final_artifact_ms, Optional(30));
  technique_.AwaitJob(1);
  now_ms_ = 1050;
  technique_.Finish();
  const JobReport other = AwaitReport(1);
  EXPECT_EQ(other.waited_ms, 30);
  EXPECT_EQ(other.computed_ms, 20);
  EXPECT_THAT(other.first_artifact_ms, Optional(50)) << "the final one was the first";
  EXPECT_THAT(other.final_artifact_ms, Optional(50));
}

TEST_F(JobReportTest, ACommitDuringAJobIsAnsweredByTheNextOne) {
  const auto subscription = Subscribe();
  technique_.AwaitJob(0);
  technique_.Pass();
  now_ms_ = 1100;
  ASSERT_TRUE(engine_.Commit("s", BoxAt(0.1f)).ok());
  const JobReport stopped = AwaitReport(0);
  EXPECT_EQ(stopped.outcome, JobReport::Outcome::kSuperseded);
  EXPECT_THAT(stopped.first_artifact_ms, Optional(0));
  EXPECT_EQ(stopped.final_artifact_ms, std::nullopt);
  technique_.AwaitJob(1);
  now_ms_ = 1105;
  technique_.Finish();
  EXPECT_THAT(AwaitReport(1).final_artifact_ms, Optional(5));
}

TEST_F(JobReportTest, FailuresAreTold) {
  const auto subscription = Subscribe();
  technique_.Fail(absl::ResourceExhaustedError("too much"));
  const JobReport report = AwaitReport(0);
  EXPECT_EQ(report.outcome, JobReport::Outcome::kFailed);
  EXPECT_EQ(report.status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(report.first_artifact_ms, std::nullopt);
}

TEST_F(JobReportTest, TheLoadOfEachSceneIsKnown) {
  ASSERT_TRUE(engine_.CreateScene("a").ok());
  const auto first = Subscribe(1);
  technique_.AwaitJob(0);
  const auto second = Subscribe(2);
  const auto loads = engine_.scene_loads();
  ASSERT_EQ(loads.size(), 2u);
  EXPECT_EQ(loads[0].scene.id, "a");
  EXPECT_EQ(loads[0].artifacts, 0u);
  EXPECT_EQ(loads[1].scene.id, "s");
  EXPECT_EQ(loads[1].scene.revision, 1u);
  EXPECT_EQ(loads[1].artifacts, 2u);
  EXPECT_EQ(loads[1].jobs_running, 1u);
  EXPECT_EQ(loads[1].jobs_waiting, 1u);
}

}  // namespace
}  // namespace penumbra::testing
