// Shares, told by a simulation: lanes that take jobs of known cost by a clock of its own.
#include "render/engine/fair_share.h"

#include <algorithm>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <queue>
#include <random>
#include <string>
#include <vector>

#include "gtest/gtest.h"

namespace penumbra::testing {
namespace {

struct Job : QueuedJob {
  double viewed_share() const override { return share; }
  double Run() override { return 0; }
  double share = 0;
};

// A party that always has jobs, or those that it is given.
struct Stream {
  std::vector<std::array<std::string, 3>> wanted_by;  // scene, principal, viewer
  std::function<double()> cost;
  std::function<double(double)> estimate = [](double exact) { return exact; };
  double weight = 1;  // of its principals
  double share = 0;   // of people's pictures
  double had_ms = 0;
  int jobs = 0;
};

struct Simulation {
  explicit Simulation(size_t lane_count) : lanes(lane_count) {}

  struct Order {
    FairShare::Entry entry;
    Stream* stream = nullptr;
    double cost = 0;
    double ends = 0;
  };

  void Add(Stream& stream) {
    auto order = std::make_unique<Order>();
    order->stream = &stream;
    order->cost = stream.cost();
    auto job = std::make_shared<Job>();
    job->share = stream.share;
    order->entry.job = std::move(job);
    order->entry.estimate = stream.estimate(order->cost);
    order->entry.arrival = ++arrivals;
    std::vector<FairShare::Path> paths;
    for (const auto& [scene, principal, viewer] : stream.wanted_by) {
      paths.push_back({{{scene}, {principal, stream.weight}, {viewer}}});
    }
    share.Add(order->entry, paths);
    orders[&order->entry] = std::move(order);
  }

  // Whose job ended next; null where no lane has one to do.
  Stream* Step() {
    for (auto& lane : lanes) {
      if (lane) continue;
      FairShare::Entry* const taken = share.Take();
      if (!taken) break;
      lane = std::move(orders.at(taken));
      orders.erase(taken);
      lane->ends = now + lane->cost;
      started.push_back(lane->stream);
    }
    auto next = lanes.end();
    for (auto lane = lanes.begin(); lane != lanes.end(); ++lane) {
      if (*lane && (next == lanes.end() || (*lane)->ends < (*next)->ends)) next = lane;
    }
    if (next == lanes.end()) return nullptr;
    now = (*next)->ends;
    Stream* const stream = (*next)->stream;
    share.End((*next)->entry, (*next)->cost);
    stream->had_ms += (*next)->cost;
    ++stream->jobs;
    next->reset();
    return stream;
  }

  // Every job that ends is followed by another of its stream.
  void RunUntil(double end) {
    while (now < end) {
      Stream* const stream = Step();
      ASSERT_NE(stream, nullptr);
      Add(*stream);
    }
  }

  FairShare share;
  std::vector<std::unique_ptr<Order>> lanes;
  std::map<FairShare::Entry*, std::unique_ptr<Order>> orders;
  std::vector<Stream*> started;
  double now = 0;
  uint64_t arrivals = 0;
};

std::function<double()> Always(double ms) {
  return [ms] { return ms; };
}

Stream Of(std::string scene, std::string principal, std::string viewer, double ms) {
  return {.wanted_by = {{std::move(scene), std::move(principal), std::move(viewer)}},
          .cost = Always(ms)};
}

// As many jobs as it likes, and as long ones: a scene's part stays the same.
TEST(FairShareTest, ScenesHaveEqualPartsWhateverTheirJobsTake) {
  Simulation simulation(2);
  Stream light = Of("light", "a", "1", 3), heavy = Of("heavy", "a", "1", 250),
         many = Of("many", "a", "1", 20);
  for (int i = 0; i < 4; ++i) simulation.Add(light);
  for (int i = 0; i < 4; ++i) simulation.Add(heavy);
  for (int i = 0; i < 100; ++i) simulation.Add(many);
  simulation.RunUntil(100'000);
  const double third = 2 * simulation.now / 3;
  for (const Stream* stream : {&light, &heavy, &many}) {
    EXPECT_NEAR(stream->had_ms, third, 0.02 * third);
  }
  EXPECT_GT(light.jobs, 20'000);
}

TEST(FairShareTest, ClientsOfASceneShareItsPartByWeightAndThenTheirViewers) {
  Simulation simulation(2);
  Stream other = Of("other", "a", "1", 7), a1 = Of("scene", "a", "1", 5),
         a2 = Of("scene", "a", "2", 11), b = Of("scene", "b", "1", 3);
  b.weight = 3;
  for (Stream* stream : {&other, &a1, &a2, &b}) {
    for (int i = 0; i < 8; ++i) simulation.Add(*stream);
  }
  simulation.RunUntil(100'000);
  const double half = simulation.now;
  EXPECT_NEAR(other.had_ms, half, 0.02 * half);
  EXPECT_NEAR(b.had_ms, half * 3 / 4, 0.02 * half);
  EXPECT_NEAR(a1.had_ms, half / 8, 0.02 * half);
  EXPECT_NEAR(a2.had_ms, half / 8, 0.02 * half);
}

// Whatever the estimates, and on any number of lanes: it waits for those that run, and for no
// other.
TEST(FairShareTest, ANewcomersFirstJobIsTheNextToStart) {
  std::minstd_rand random(7);
  const auto between = [&random](double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random);
  };
  for (int round = 0; round < 200; ++round) {
    Simulation simulation(1 + round % 3);
    std::deque<Stream> hogs;
    for (int i = 0; i < 5; ++i) {
      static constexpr const char* kScenes[] = {"hog0", "hog1", "hog2"};
      static constexpr const char* kPrincipals[] = {"p0", "p1"};
      Stream& hog = hogs.emplace_back(Of(kScenes[i % 3], kPrincipals[i % 2], std::to_string(i), 0));
      hog.cost = [&] { return between(1, 100); };
      hog.estimate = [&](double exact) { return exact * between(0, 2); };
      for (int k = 0; k < 20; ++k) simulation.Add(hog);
    }
    simulation.RunUntil(between(3'000, 9'000));  // all have had something
    Stream newcomer = Of("newcomer", "n", "1", 5);
    simulation.Add(newcomer);
    const size_t before = simulation.started.size();
    while (simulation.started.size() == before) ASSERT_NE(simulation.Step(), nullptr);
    EXPECT_EQ(simulation.started[before], &newcomer) << "round " << round;
    // The same within a scene: of its jobs the guest's is the next.
    Stream guest = Of("hog0", "guest", "1", 5);
    simulation.Add(guest);
    for (size_t i = simulation.started.size();; i = simulation.started.size()) {
      Stream* const ended = simulation.Step();
      ASSERT_NE(ended, nullptr);
      if (ended != &guest && ended != &newcomer) simulation.Add(*ended);
      if (i == simulation.started.size()) continue;
      if (simulation.started.back() == &guest) break;
      for (; i < simulation.started.size(); ++i) {
        EXPECT_NE(simulation.started[i]->wanted_by[0][0], "hog0") << "round " << round;
      }
    }
  }
}

TEST(FairShareTest, IdlingEarnsNothing) {
  Simulation simulation(1);
  Stream busy = Of("busy", "a", "1", 10), idle = Of("idle", "a", "1", 10);
  for (int i = 0; i < 50; ++i) simulation.Add(busy);
  simulation.RunUntil(100'000);
  for (int i = 0; i < 50; ++i) simulation.Add(idle);
  const double before = busy.had_ms;
  simulation.RunUntil(simulation.now + 1'000);
  EXPECT_NEAR(idle.had_ms, busy.had_ms - before, 20);
}

// A client that asks for one job after another is always at the front, and has no more for it.
TEST(FairShareTest, ComingBackIsNoWayToTheFront) {
  Simulation simulation(1);
  Stream steady = Of("steady", "a", "1", 10), returning = Of("returning", "a", "1", 30);
  for (int i = 0; i < 10; ++i) simulation.Add(steady);
  simulation.Add(returning);
  while (simulation.now < 100'000) {
    Stream* const ended = simulation.Step();
    ASSERT_NE(ended, nullptr);
    if (ended == &steady) {
      simulation.Add(steady);
      continue;
    }
    // Not there when the next job is chosen.
    Stream* const between = simulation.Step();
    ASSERT_EQ(between, &steady);
    simulation.Add(steady);
    simulation.Add(returning);
  }
  EXPECT_LE(returning.had_ms, 0.52 * simulation.now);
  EXPECT_GE(returning.had_ms, 0.45 * simulation.now);
}

// Nobody knew that its job would take a second.
TEST(FairShareTest, WhatAJobTookCountsThoughNobodyKnew) {
  Simulation simulation(1);
  Stream surprise = Of("surprise", "a", "1", 1'000), other = Of("other", "a", "1", 10);
  surprise.estimate = [](double) { return 0.01; };
  simulation.Add(surprise);
  simulation.Add(surprise);
  simulation.Step();
  for (int i = 0; i < 200; ++i) simulation.Add(other);
  simulation.Step();
  EXPECT_EQ(other.jobs, 1);
  while (surprise.jobs < 2) ASSERT_NE(simulation.Step(), nullptr);
  EXPECT_NEAR(other.had_ms, 1'000, 20) << "as much as the surprise, before it has another";
}

// What several want runs when the first of them has its turn, and each bears its part.
TEST(FairShareTest, AJobForSeveralCountsForEachByItsPart) {
  Simulation simulation(1);
  Stream both = Of("scene", "a", "1", 10), mine = Of("scene", "a", "1", 10),
         yours = Of("scene", "b", "1", 10);
  both.wanted_by.push_back({"scene", "b", "1"});
  both.share = 1;  // somebody looks at it
  for (int i = 0; i < 3; ++i) {
    simulation.Add(both);
    simulation.Add(mine);
    simulation.Add(yours);
  }
  Stream third = Of("scene", "c", "1", 10);
  simulation.Add(third);
  simulation.Add(third);
  simulation.RunUntil(30'000);
  const double parts[] = {mine.had_ms + both.had_ms / 2, yours.had_ms + both.had_ms / 2,
                          third.had_ms};
  for (const double part : parts) EXPECT_NEAR(part, 10'000, 200);
  EXPECT_GT(both.had_ms, 0);
}

TEST(FairShareTest, OfOnesOwnJobsTheOneLookedAtMostRunsFirstThenTheOldest) {
  Simulation simulation(1);
  std::deque<Stream> streams;
  for (const double share : {0.0, 0.2, 0.7, 0.2, 0.0}) {
    streams.push_back(Of("scene", "a", "1", 1));
    streams.back().share = share;
    simulation.Add(streams.back());
  }
  while (simulation.Step()) {
  }
  const std::vector<Stream*> expected{&streams[2], &streams[1], &streams[3], &streams[0],
                                      &streams[4]};
  EXPECT_EQ(simulation.started, expected);
}

TEST(FairShareTest, WhatIsRemovedIsNotTakenAndCountsForNobody) {
  FairShare share;
  const FairShare::Path mine{{{"s"}, {"a"}, {"1"}}}, yours{{{"s"}, {"b"}, {"1"}}};
  FairShare::Entry first{.job = std::make_shared<Job>(), .estimate = 1, .arrival = 1};
  FairShare::Entry second{.job = std::make_shared<Job>(), .estimate = 1, .arrival = 2};
  const std::vector<FairShare::Path> both{mine, yours};
  share.Add(first, both);
  share.Add(second, {&yours, 1});
  share.Remove(first);
  EXPECT_EQ(share.Take(), &second);
  EXPECT_TRUE(share.is_empty());
  EXPECT_EQ(share.Take(), nullptr);
  share.End(second, 1);
  share.Add(first, both);
  EXPECT_EQ(share.Take(), &first);
  share.End(first, 1);
}

}  // namespace
}  // namespace penumbra::testing
