// The queue with threads, and an engine whose clock goes on as its jobs say.
#include "render/engine/job_queue.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <latch>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "gtest/gtest.h"
#include "render/engine/local_engine.h"
#include "render/scene/field_error.h"
#include "render/scene/retry_delay.h"
#include "tests/unit/engine/scripted_technique.h"

namespace penumbra::testing {
namespace {

using Names = std::vector<std::string>;

class FunctionJob : public QueuedJob {
 public:
  explicit FunctionJob(std::function<double()> run) : run_(std::move(run)) {}
  double viewed_share() const override { return 0; }
  double Run() override { return run_(); }

 private:
  const std::function<double()> run_;
};

JobFor For(std::string scene_id, Parties parties) {
  return {std::move(scene_id), std::make_shared<const Parties>(std::move(parties))};
}

class TestAccounts : public ComputeAccounts {
 public:
  Standing StandingOf(const std::string& principal) override {
    std::lock_guard lock(mutex_);
    return {.weight = weights.contains(principal) ? weights[principal] : 1.0,
            .gives_way = most_ms.contains(principal) && had_ms[principal] > most_ms[principal]};
  }
  void Charge(const std::string& principal, double ms) override {
    std::lock_guard lock(mutex_);
    had_ms[principal] += ms;
  }

  std::map<std::string, double> weights, most_ms, had_ms;

 private:
  std::mutex mutex_;
};

// One thread, which a first job holds until it may go.
class JobQueueTest : public ::testing::Test {
 protected:
  ~JobQueueTest() override { pool_.Stop(); }

  void Hold() {
    queue_.Add(std::make_shared<FunctionJob>([this] {
                 holds_.count_down();
                 may_go_.wait();
                 return 0.0;
               }),
               {"held"}, 0);
    holds_.wait();
  }
  std::shared_ptr<QueuedJob> Add(const JobFor& whom, const std::string& name, double ms) {
    auto job = std::make_shared<FunctionJob>([this, name, ms] {
      ran_.push_back(name);
      left_.fetch_sub(1);
      return ms;
    });
    left_.fetch_add(1);
    queue_.Add(job, whom, ms);
    return job;
  }
  const Names& RunAll() {
    may_go_.count_down();
    while (left_ > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return ran_;
  }

  TestAccounts accounts_;
  WorkerPool pool_{{1}};
  JobQueue queue_{pool_.lane(0), &accounts_};
  std::latch holds_{1}, may_go_{1};
  std::atomic<int> left_{0};
  Names ran_;
};

TEST_F(JobQueueTest, ScenesTakeTurnsByWhatTheirJobsTake) {
  Hold();
  for (int i = 0; i < 3; ++i) Add(For("heavy", {{"a", "1"}}), "heavy", 40);
  for (int i = 0; i < 8; ++i) Add(For("light", {{"a", "1"}}), "light", 10);
  EXPECT_EQ(RunAll(), (Names{"heavy", "light", "light", "light", "light", "heavy", "light", "light",
                             "light", "light", "heavy"}));
}

TEST_F(JobQueueTest, AJobThatIsRemovedDoesNotRunAndLeavesNothingBehind) {
  Hold();
  for (int i = 0; i < 1'000; ++i) {
    const auto job = Add({"s"}, "removed", 1);
    queue_.Remove(*job);
    left_.fetch_sub(1);
  }
  EXPECT_EQ(queue_.waiting(), 0u);
  Add({"s"}, "stays", 1);
  EXPECT_EQ(RunAll(), Names{"stays"});
}

TEST_F(JobQueueTest, WhoJoinsOneThatWaitsBringsItForward) {
  Hold();
  Add(For("s", {{"hog", "1"}}), "first", 10);
  Add(For("s", {{"hog", "1"}}), "second", 10);
  const auto shared = Add(For("s", {{"hog", "1"}}), "shared", 10);
  queue_.Change(*shared, For("s", {{"guest", "1"}, {"hog", "1"}}));
  EXPECT_EQ(RunAll(), (Names{"first", "shared", "second"}));
}

TEST_F(JobQueueTest, PrincipalsThatHadTheirPartGiveWayAndAreNotForgotten) {
  accounts_.most_ms["greedy"] = 15;
  Hold();
  for (int i = 0; i < 4; ++i) Add(For("a", {{"greedy", "1"}}), "greedy", 10);
  for (int i = 0; i < 6; ++i) Add(For("b", {{"other", "1"}}), "other", 10);
  // What others want too does not wait.
  Add(For("c", {{"greedy", "1"}, {"other", "1"}}), "both", 10);
  const Names& ran = RunAll();
  EXPECT_EQ(Names(ran.begin() + 9, ran.end()), (Names{"greedy", "greedy"}))
      << "two, then the rest once nobody else waits";
  EXPECT_EQ(std::count(ran.begin(), ran.begin() + 9, "both"), 1);
  EXPECT_EQ(accounts_.had_ms["greedy"], 45);
  EXPECT_EQ(accounts_.had_ms["other"], 65);
}

// An engine with one thread, which the scene "first" holds, and a clock that its jobs move on.
class FairEngineTest : public ::testing::Test {
 protected:
  FairEngineTest() {
    for (const char* id : {"first", "hog", "light"}) {
      EXPECT_TRUE(engine_.CreateScene(id).ok());
      EXPECT_TRUE(engine_.Commit(id, LampAndFloor()).ok());
    }
  }
  void Follow(const std::string& scene, const std::string& viewer, int count) {
    for (int i = 0; i < count; ++i) {
      subscriptions_.push_back(
          engine_.SubscribeFor({"me", viewer}, scene, LampOnFloor(i + 1), log_.Callback()).value());
    }
  }
  absl::StatusOr<Artifact> Compute(const Scene& scene) {
    if (scene.id() == "first") {
      holds_.count_down();
      may_go_.wait();
    } else {
      std::lock_guard lock(mutex_);
      order_.push_back(scene.id());
    }
    now_ms_ = now_ms_ + (scene.id() == "hog" ? 50 : 5);
    return LabelledArtifact(scene, 0, true);
  }

  std::atomic<double> now_ms_{0};
  std::latch holds_{1}, may_go_{1};
  std::mutex mutex_;
  Names order_;
  const FunctionTechnique technique_{[this](const Scene& scene, const ArtifactSpec&,
                                            const ComputeContext&) { return Compute(scene); }};
  LocalEngine engine_{[this] {
    LocalEngineOptions options = OptionsFor(technique_);
    options.runner_threads = 1;
    options.now_ms = [this] { return now_ms_.load(); };
    return options;
  }()};
  UpdateLog log_;
  std::vector<std::unique_ptr<SharedSubscription>> subscriptions_;
};

// What is measured decides, and the jobs of a channel are charged as they end.
TEST_F(FairEngineTest, AHogsJobsRunAsOftenAsTheirTimeAllows) {
  Follow("first", "1", 1);
  holds_.wait();
  Follow("hog", "1", 100);
  Follow("light", "2", 20);
  may_go_.count_down();
  log_.AwaitCount(121);
  std::lock_guard lock(mutex_);
  ASSERT_EQ(order_.size(), 120u);
  EXPECT_EQ(std::count(order_.begin(), order_.begin() + 22, "light"), 20)
      << "twenty of 5 ms while the hog has two of 50";
}

TEST(ArtifactsOfAllScenesTest, AreCounted) {
  const FunctionTechnique technique(
      [](const Scene& scene, const ArtifactSpec&, const ComputeContext&) {
        return LabelledArtifact(scene, 0, true);
      });
  LocalEngineOptions options = OptionsFor(technique);
  options.max_artifacts = 2;
  LocalEngine engine(options);
  UpdateLog log;
  for (const char* id : {"a", "b"}) {
    ASSERT_TRUE(engine.CreateScene(id).ok());
    ASSERT_TRUE(engine.Commit(id, LampAndFloor()).ok());
  }
  auto first = engine.Subscribe("a", LampOnFloor(1), log.Callback()).value();
  const auto second = engine.Subscribe("b", LampOnFloor(1), log.Callback()).value();
  EXPECT_TRUE(engine.Subscribe("b", LampOnFloor(1), log.Callback()).ok()) << "the same artifact";
  const absl::Status over = engine.Subscribe("b", LampOnFloor(2), log.Callback()).status();
  EXPECT_EQ(ErrorReason(over), "QUOTA_ARTIFACTS");
  EXPECT_EQ(ErrorFieldPath(over), "spec");
  EXPECT_TRUE(RetryDelayMs(over)) << "others may go";
  log.AwaitCount(2);
  first.reset();
  // Gone once its job has let go of it.
  for (int i = 0; i < 1'000; ++i) {
    if (engine.Subscribe("b", LampOnFloor(2), log.Callback()).ok()) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  FAIL() << "it is still counted";
}

}  // namespace
}  // namespace penumbra::testing
