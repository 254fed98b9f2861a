#include "server/delay_trend.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "server/scene_store/commit_admission.h"

namespace penumbra::testing {
namespace {

using std::chrono::milliseconds;
using Clock = DelayTrend::Clock;

// Messages five milliseconds after one another, or as soon as the one before has come.
class DelayTrendTest : public ::testing::Test {
 protected:
  // Each takes so many milliseconds.
  void Come(const std::vector<int>& delays) {
    for (const int delay : delays) {
      trend_.OnSent(now_);
      Wait(delay);
      trend_.OnCame(now_);
      if (delay < 5) Wait(5 - delay);
    }
  }
  // For each millisecond the greatest that it said is noted.
  void Wait(int ms) {
    for (; ms > 0; --ms) {
      now_ += milliseconds(1);
      greatest_ = std::max(greatest_, trend_.Now(now_));
    }
  }

  // Ten requests a millisecond, of which one in so many is refused.
  void Ask(int ms, int one_in) {
    for (int i = 0; i < 10 * ms; ++i) {
      if (i % 10 == 0) Wait(1);
      trend_.OnAdmission(i % one_in == 0, now_);
    }
  }

  Clock::time_point now_ = Clock::time_point() + std::chrono::hours(1);
  DelayTrend trend_;
  Clock::duration greatest_{};
};

TEST_F(DelayTrendTest, NothingIsNoDelay) {
  EXPECT_EQ(trend_.Now(now_), Clock::duration::zero());
  Come({1, 2, 5, 1});
  EXPECT_EQ(greatest_, Clock::duration::zero());
}

TEST_F(DelayTrendTest, OneLateIsNoDelay) {
  Come({1, 30, 1, 1, 5, 80, 2});
  EXPECT_EQ(greatest_, Clock::duration::zero());
}

// What has piled up while the machine stood still is read faster than more comes.
TEST_F(DelayTrendTest, APauseIsNoDelay) {
  Come({1, 1, 72, 40, 22, 12, 7, 4, 2, 1});
  EXPECT_EQ(greatest_, Clock::duration::zero());
  Come({200, 160, 128, 102, 82, 65, 52, 42, 33, 27, 21, 17, 14, 11, 9, 7, 5, 1});
  EXPECT_EQ(greatest_, Clock::duration::zero()) << "at four fifths of what can be read";
}

TEST_F(DelayTrendTest, WhatHardlyGetsLessIsADelay) {
  Come({240, 230, 220});
  EXPECT_EQ(trend_.Now(now_), milliseconds(220));
}

// Twice of what can be read comes: each waits twice as long as the one before.
TEST_F(DelayTrendTest, MoreThanIsReadIsADelaySoon) {
  Come({1, 2, 4, 8});
  EXPECT_EQ(trend_.Now(now_), Clock::duration::zero());
  trend_.OnSent(now_);
  Wait(8);
  EXPECT_EQ(trend_.Now(now_), milliseconds(8)) << "no sooner than the one before, already";
  Wait(8);
  trend_.OnCame(now_);
  EXPECT_EQ(trend_.Now(now_), milliseconds(16));
  Come({9});
  EXPECT_EQ(trend_.Now(now_), milliseconds(9)) << "one is enough now";
  Come({1});
  EXPECT_EQ(trend_.Now(now_), milliseconds(1));
}

TEST_F(DelayTrendTest, ForASecondAllCount) {
  Come({10, 10, 1});
  Wait(900);
  Come({5});
  EXPECT_EQ(trend_.Now(now_), milliseconds(5));
  Wait(200);
  Come({11});
  EXPECT_EQ(trend_.Now(now_), Clock::duration::zero());
}

TEST_F(DelayTrendTest, AndForAnotherAfterEachThatIsVeryLate) {
  Come({10, 10, 1});
  for (int i = 0; i < 10; ++i) {
    Wait(900);
    Come({12});
    EXPECT_EQ(trend_.Now(now_), milliseconds(12));
  }
  Wait(900);
  Come({7, 6});
  Wait(900);
  Come({1});
  EXPECT_EQ(trend_.Now(now_), milliseconds(1)) << "or two that are late";
  Wait(200);
  Come({12});
  EXPECT_EQ(trend_.Now(now_), Clock::duration::zero());
}

// They come back: nothing is late because they were sent away.
TEST_F(DelayTrendTest, AndWhileManyAreRefused) {
  Come({10, 10, 1});
  Ask(4'500, 25);
  Come({3});
  EXPECT_EQ(trend_.Now(now_), milliseconds(3));
  Ask(3'000, 25);
  Come({3});
  EXPECT_EQ(trend_.Now(now_), Clock::duration::zero()) << "but not for ever";
}

TEST_F(DelayTrendTest, FewThatAreRefusedDoNotProlongIt) {
  Come({10, 10, 1});
  Ask(1'100, 40);
  Come({3});
  EXPECT_EQ(trend_.Now(now_), Clock::duration::zero());
  Ask(5, 1);
  Come({3});
  EXPECT_EQ(trend_.Now(now_), Clock::duration::zero()) << "and nothing begins so";
  Come({10, 10, 1});
  Wait(2'000);
  Ask(1, 1);
  Come({3});
  EXPECT_EQ(trend_.Now(now_), Clock::duration::zero()) << "nor when it is long over";
}

// At a fifth of the limit some are refused on alert, which does not keep itself alive.
TEST_F(DelayTrendTest, AUsualDelayEndsIt) {
  const ServerLimits limits;
  const CommitSender sender{.share = {.of_mean = 1, .sessions = 200}, .has_unanswered = true};
  Come({10, 10});
  int refused_at_first = 0, refused = 0;
  for (int i = 0; i < 2'000; ++i) {
    Come({2});
    for (int request = 0; request < 10; ++request) {
      const auto status = AdmitByReadDelay(trend_.Now(now_), request / 10.0, sender, limits);
      trend_.OnAdmission(!status.ok(), now_);
      (i < 1'400 ? refused_at_first : refused) += !status.ok();
    }
  }
  EXPECT_GT(refused_at_first, 0);
  EXPECT_EQ(refused, 0) << "after seven seconds";
}

TEST_F(DelayTrendTest, OneThatDoesNotComeCounts) {
  trend_.OnSent(now_);
  Wait(249);
  EXPECT_EQ(greatest_, Clock::duration::zero());
  Wait(1);
  EXPECT_EQ(trend_.Now(now_), milliseconds(250));
  Wait(1'000);
  EXPECT_EQ(trend_.Now(now_), milliseconds(1'250));
  trend_.OnLost();
  EXPECT_EQ(trend_.Now(now_), Clock::duration::zero());
}

TEST_F(DelayTrendTest, WhatIsOldSaysNothing) {
  Come({10});
  Wait(250);
  Come({10});
  Come({8});
  EXPECT_EQ(greatest_, Clock::duration::zero()) << "two in a row, but long after one another";
  Come({8});
  EXPECT_EQ(trend_.Now(now_), milliseconds(8));
  Come({1});
  Wait(1'100);
  Come({10});
  Wait(200);
  trend_.OnSent(now_);
  Wait(100);
  EXPECT_EQ(trend_.Now(now_), milliseconds(100)) << "the one before was not old when it was sent";
  trend_.OnCame(now_);
  Wait(250);
  EXPECT_EQ(trend_.Now(now_), Clock::duration::zero());
}

}  // namespace
}  // namespace penumbra::testing
