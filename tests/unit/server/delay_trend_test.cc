#include "server/delay_trend.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <vector>

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
  for (int second = 0; second < 10; ++second) {
    Wait(700);
    for (int i = 0; i < 200; ++i) trend_.OnAdmission(i % 30 == 0, now_);
    Come({3});
    EXPECT_EQ(trend_.Now(now_), milliseconds(3)) << second;
  }
  Wait(700);
  for (int i = 0; i < 1'000; ++i) trend_.OnAdmission(i % 40 == 0, now_);
  Wait(300);
  Come({3});
  EXPECT_EQ(trend_.Now(now_), Clock::duration::zero()) << "five of 200 are few";
  for (int i = 0; i < 1'000; ++i) trend_.OnAdmission(true, now_);
  Come({3});
  EXPECT_EQ(trend_.Now(now_), Clock::duration::zero()) << "it does not begin so";
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
  Come({9});
  EXPECT_EQ(greatest_, Clock::duration::zero()) << "two in a row, but long after one another";
  Come({9});
  EXPECT_EQ(trend_.Now(now_), milliseconds(9));
  Wait(250);
  EXPECT_EQ(trend_.Now(now_), Clock::duration::zero());
}

}  // namespace
}  // namespace penumbra::testing
