#include "server/request_shares.h"

#include <gtest/gtest.h>

#include <chrono>
#include <string>

namespace penumbra::testing {
namespace {

using std::chrono::milliseconds;

class RequestSharesTest : public ::testing::Test {
 protected:
  // The last of as many requests as are given, each a millisecond after the one before.
  double Send(int times, const std::string& principal, const int& session) {
    double share = 0;
    for (int i = 0; i < times; ++i) {
      share = shares_.OnRequest(principal, &session, now_ += milliseconds(1)).of_mean;
    }
    return share;
  }

  RequestShares shares_;
  RequestShares::Clock::time_point now_{std::chrono::hours(1)};
  const int one_ = 0, two_ = 0, three_ = 0, four_ = 0;
};

TEST_F(RequestSharesTest, IsOneForWhoeverIsAlone) {
  EXPECT_DOUBLE_EQ(Send(1, "ana", one_), 1);
  EXPECT_DOUBLE_EQ(Send(10'000, "ana", one_), 1);
}

TEST_F(RequestSharesTest, IsOneForAllWhereAllSendAsMuch) {
  double ana = 0, ben = 0;
  for (int i = 0; i < 2'000; ++i) {
    ana = Send(1, "ana", one_);
    ben = Send(1, "ben", two_);
  }
  EXPECT_NEAR(ana, 1, 0.01);
  EXPECT_NEAR(ben, 1, 0.01);
}

TEST_F(RequestSharesTest, IsSmallForWhoeverSendsLittle) {
  Send(500, "greedy", one_);
  EXPECT_NEAR(Send(5, "modest", two_), 5 / (505 / 2.0), 0.005);
  EXPECT_NEAR(Send(1, "greedy", one_), 501 / (506 / 2.0), 0.03);
}

TEST_F(RequestSharesTest, ManySessionsMakeNoPrincipalModest) {
  for (const int* session : {&one_, &two_, &three_}) Send(100, "greedy", *session);
  EXPECT_LT(Send(10, "modest", four_), 0.15);
  EXPECT_GE(Send(1, "greedy", one_), 1);
}

TEST_F(RequestSharesTest, ASessionIsNotTakenForAnotherOfItsPrincipal) {
  Send(500, "all", one_);
  EXPECT_LT(Send(5, "all", two_), 0.05);
}

TEST_F(RequestSharesTest, CountsWhoSends) {
  Send(100, "ana", one_);
  Send(1, "ana", two_);
  const auto sessions = [&] { return shares_.OnRequest("ben", &three_, now_).sessions; };
  EXPECT_EQ(sessions(), 3u);
  now_ += milliseconds(3'000);
  EXPECT_EQ(sessions(), 2u) << "one request is soon forgotten";
}

TEST_F(RequestSharesTest, WhatIsLongAgoIsForgotten) {
  Send(500, "greedy", one_);
  now_ += milliseconds(12'000);
  EXPECT_DOUBLE_EQ(Send(1, "modest", two_), 1) << "and whoever sends no more is no sender";
  now_ += std::chrono::hours(24);
  EXPECT_DOUBLE_EQ(Send(1, "greedy", one_), 1);
}

}  // namespace
}  // namespace penumbra::testing
