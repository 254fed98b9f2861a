// When callbacks run, and when they no longer do.
#include <atomic>
#include <future>
#include <latch>
#include <thread>

#include "gtest/gtest.h"
#include "render/engine/local_engine.h"
#include "tests/unit/engine/scripted_technique.h"

namespace penumbra::testing {
namespace {

class SubscriptionTest : public ::testing::Test {
 protected:
  SubscriptionTest() {
    EXPECT_TRUE(engine_.CreateScene("s").ok());
    EXPECT_TRUE(engine_.Commit("s", LampAndFloor()).ok());
  }
  std::unique_ptr<Subscription> Subscribe(ArtifactCallback callback) {
    return engine_.Subscribe("s", LampOnFloor(), std::move(callback)).value();
  }

  ScriptedTechnique technique_;
  LocalEngine engine_{OptionsFor(technique_)};
};

TEST_F(SubscriptionTest, ASlowCallbackHoldsUpNeitherCommitsNorOthers) {
  std::latch entered(1), leave(1);
  std::vector<Revision> slow_saw;
  UpdateLog log;
  auto slow = Subscribe([&](const ArtifactUpdate& update) {
    slow_saw.push_back(update.revision);
    if (slow_saw.size() > 1) return;
    entered.count_down();
    leave.wait();
  });
  const auto quick = Subscribe(log.Callback());
  technique_.Finish();
  entered.wait();
  log.AwaitFinalAt(1);  // or the next commit may overtake it
  for (Revision revision = 2; revision <= 20; ++revision) {
    ASSERT_EQ(engine_.Commit("s", BoxAt(0.001f * revision)).value(), revision);
    technique_.Finish();
    log.AwaitFinalAt(revision);
  }
  leave.count_down();
  // What comes after: the newest alone.
  while (engine_.statistics().callbacks_run < 20 + 2) std::this_thread::yield();
  slow.reset();
  EXPECT_EQ(slow_saw, (std::vector<Revision>{1, 20}));
}

TEST_F(SubscriptionTest, EndingWaitsForTheCallbackThatRuns) {
  std::latch entered(1);
  std::promise<void> leave;
  std::atomic<bool> left = false;
  auto subscription = Subscribe([&](const ArtifactUpdate&) {
    entered.count_down();
    leave.get_future().wait();
    left = true;
  });
  technique_.Finish();
  entered.wait();
  std::thread ending([&] {
    subscription.reset();
    EXPECT_TRUE(left);
  });
  leave.set_value();
  ending.join();
}

TEST_F(SubscriptionTest, MayEndFromInsideItsOwnCallback) {
  std::atomic<int> calls = 0;
  std::unique_ptr<Subscription> subscription;
  std::latch assigned(1), ended(1);
  UpdateLog other;
  const auto witness = Subscribe(other.Callback());
  subscription = Subscribe([&](const ArtifactUpdate&) {
    assigned.wait();
    ++calls;
    subscription.reset();
    ended.count_down();
  });
  assigned.count_down();
  technique_.Finish();
  ended.wait();
  ASSERT_TRUE(engine_.Commit("s", BoxAt(0.1f)).ok());
  technique_.Finish();
  other.AwaitFinalAt(2);
  EXPECT_EQ(calls, 1);
}

TEST_F(SubscriptionTest, WhatTheCallbackHoldsDiesWithTheSubscription) {
  auto held = std::make_shared<int>(1);
  const std::weak_ptr<int> watch = held;
  auto subscription = Subscribe([held](const ArtifactUpdate&) {});
  held.reset();
  EXPECT_FALSE(watch.expired());
  subscription.reset();
  EXPECT_TRUE(watch.expired());
}

TEST(SubscriptionLifeTest, MayOutliveTheEngine) {
  const ScriptedTechnique technique;
  UpdateLog log;
  std::unique_ptr<Subscription> subscription;
  {
    LocalEngine engine(OptionsFor(technique));
    ASSERT_TRUE(engine.CreateScene("s").ok());
    ASSERT_TRUE(engine.Commit("s", LampAndFloor()).ok());
    subscription = engine.Subscribe("s", LampOnFloor(), log.Callback()).value();
  }
  subscription.reset();
  EXPECT_TRUE(log.all().empty());
}

// Commits, subscriptions and their ends from several threads: nothing is lost, out of order or
// late.
TEST(SubscriptionStressTest, ManyThreads) {
  const FunctionTechnique quick([](const Scene& scene, const ArtifactSpec&,
                                   const ComputeContext& context) -> absl::StatusOr<Artifact> {
    context.progress(LabelledArtifact(scene, 0, false));
    if (context.stop.stop_requested()) return absl::CancelledError("stopped");
    return LabelledArtifact(scene, 1, true);
  });
  LocalEngine engine(OptionsFor(quick));
  ASSERT_TRUE(engine.CreateScene("s").ok());
  ASSERT_TRUE(engine.Commit("s", LampAndFloor()).ok());
  constexpr int kThreads = 4, kCommits = 100;
  UpdateLog log;
  const auto lasting = engine.Subscribe("s", LampOnFloor(), log.Callback()).value();
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&engine, t] {
      for (int i = 0; i < kCommits; ++i) {
        ASSERT_TRUE(engine.Commit("s", BoxAt(0.001f * (i + t))).ok());
        std::atomic<bool> alive = true;
        auto brief = engine.Subscribe("s", LampOnFloor(i % 3),
                                      [&alive](const ArtifactUpdate&) { EXPECT_TRUE(alive); });
        if (i % 2 == 0) std::this_thread::yield();
        brief->reset();
        alive = false;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  const auto updates = log.AwaitFinalAt(1 + kThreads * kCommits);
  for (size_t i = 1; i < updates.size(); ++i) {
    EXPECT_LE(updates[i - 1].revision, updates[i].revision);
  }
}

}  // namespace
}  // namespace penumbra::testing
