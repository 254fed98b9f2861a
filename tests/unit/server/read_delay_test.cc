#include "server/read_delay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <vector>

#include "tests/support/held_threads.h"

namespace penumbra::testing {
namespace {

using std::chrono::milliseconds;
using Clock = ReadDelay::Clock;

// A message is sent, and has come when this returns, if it can.
void Ask(ReadDelay& delay) {
  std::this_thread::sleep_for(milliseconds(10));
  for (int i = 0; i < 16; ++i) delay.OnRequest();
  std::this_thread::sleep_for(milliseconds(10));
}

TEST(ReadDelayTest, IsNoneWhereNobodyAsks) {
  ReadDelay delay;
  EXPECT_EQ(delay.Now(), Clock::duration::zero());
  for (int i = 0; i < 7; ++i) delay.OnRequest();
  std::this_thread::sleep_for(milliseconds(20));
  EXPECT_EQ(delay.Now(), Clock::duration::zero()) << "seven requests are no load";
}

TEST(ReadDelayTest, IsNoneWhereFewAsk) {
  ReadDelay delay;
  HeldThreads held;
  for (int i = 0; i < 120; ++i) {
    delay.OnRequest();
    std::this_thread::sleep_for(milliseconds(5));
  }
  EXPECT_EQ(delay.Now(), Clock::duration::zero()) << "200 a second are no load";
}

TEST(ReadDelayTest, IsShortWhereThereIsTime) {
  ReadDelay delay;
  int late = 0;
  for (int i = 0; i < 150; ++i) {
    Ask(delay);
    late += delay.Now() >= milliseconds(6);
  }
  EXPECT_LT(late, 75) << "on a machine that does other things besides";
}

TEST(ReadDelayTest, GrowsWhileNobodyReadsAndIsGoneAgain) {
  ReadDelay delay;
  Ask(delay);
  {
    HeldThreads held;
    Ask(delay);
    std::this_thread::sleep_for(milliseconds(300));
    const auto some = delay.Now();
    EXPECT_GE(some, milliseconds(300)) << "what is still under way counts";
    std::this_thread::sleep_for(milliseconds(100));
    EXPECT_GE(delay.Now(), some + milliseconds(90));
  }
  std::this_thread::sleep_for(milliseconds(1'500));
  EXPECT_EQ(delay.Now(), Clock::duration::zero());
}

TEST(ReadDelayTest, LotsAreSpreadEvenly) {
  ReadDelay delay;
  std::vector<double> lots;
  for (int i = 0; i < 1'000; ++i) lots.push_back(delay.OnRequest());
  std::ranges::sort(lots);
  for (size_t i = 0; i < lots.size(); ++i) EXPECT_NEAR(lots[i], i / 1e3, 0.01);
}

// Of clients that take turns none is unlucky for long, however many they are.
TEST(ReadDelayTest, LotsOfClientsThatTakeTurnsAreSpreadToo) {
  for (const int clients : {2, 16, 55, 89, 144, 200}) {
    ReadDelay delay;
    std::vector<int> in_a_row(clients);
    int longest = 0;
    for (int round = 0; round < 500; ++round) {
      for (int& unlucky : in_a_row) {
        unlucky = delay.OnRequest() < 0.5 ? unlucky + 1 : 0;
        longest = std::max(longest, unlucky);
      }
    }
    EXPECT_LT(longest, 30) << clients;
  }
}

}  // namespace
}  // namespace penumbra::testing
