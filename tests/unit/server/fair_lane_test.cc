#include "server/fair_lane.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <latch>
#include <memory>
#include <string>
#include <vector>

namespace penumbra::testing {
namespace {

using ::testing::ElementsAre;

// One task at a time, all of which wait until Release.
class FairLaneTest : public ::testing::Test {
 protected:
  void SetUp() override {
    lane_.Post("first", [this] {
      has_begun_.count_down();
      may_go_on_.wait();
    });
    has_begun_.wait();
  }
  ~FairLaneTest() override { pool_.Stop(); }
  void Post(const std::string& party, const std::string& name) {
    lane_.Post(party, [this, name] { order_.push_back(name); });
  }
  // Until all that this party has posted has run.
  void Release(const std::string& party) {
    std::latch done(1);
    lane_.Post(party, [&] { done.count_down(); });
    may_go_on_.count_down();
    done.wait();
  }

  std::latch has_begun_{1}, may_go_on_{1};
  std::vector<std::string> order_;
  WorkerPool pool_{std::vector<int>{1}};
  FairLane lane_{pool_.lane(0)};
};

TEST_F(FairLaneTest, PartiesTakeTurnsWhateverEachHasWaiting) {
  for (const char* name : {"g1", "g2", "g3"}) Post("greedy", name);
  Post("modest", "m1");
  Post("another", "a1");
  Post("greedy", "g4");
  lane_.Post("greedy", [this] { Post("late", "l1"); });
  Post("greedy", "g6");
  Release("greedy");
  EXPECT_THAT(order_, ElementsAre("g1", "m1", "a1", "g2", "g3", "g4", "l1", "g6"))
      << "whoever comes last waits for one of theirs";
}

TEST_F(FairLaneTest, WhatOnePartyPostsRunsInItsOrder) {
  for (const char* name : {"1", "2", "3", "4"}) Post("one", name);
  Release("one");
  EXPECT_THAT(order_, ElementsAre("1", "2", "3", "4"));
}

TEST_F(FairLaneTest, StoppingDropsWhatHasNotBegun) {
  auto held = std::make_shared<int>(0);
  const std::weak_ptr<int> seen = held;
  lane_.Post("one", [this, held = std::move(held)] { order_.push_back("ran"); });
  // The task that runs ends once the pool has dropped this one.
  std::shared_ptr<void> dropped(nullptr, [this](void*) { may_go_on_.count_down(); });
  pool_.lane(0).Post([dropped = std::move(dropped)] {});
  pool_.Stop();
  EXPECT_FALSE(seen.expired());
  lane_.Stop();
  EXPECT_TRUE(seen.expired());
  Post("one", "later");
  EXPECT_THAT(order_, ElementsAre());
}

}  // namespace
}  // namespace penumbra::testing
