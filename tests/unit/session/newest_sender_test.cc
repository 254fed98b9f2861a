#include "client/session/newest_sender.h"

#include <gtest/gtest.h>

#include <future>
#include <vector>

namespace penumbra::testing {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

v1::Presence Selecting(int count) {
  v1::Presence presence;
  presence.set_colour_rgb(static_cast<uint32_t>(count));
  return presence;
}

class NewestSenderTest : public ::testing::Test {
 protected:
  struct Sent {
    uint32_t colour;
    Clock::time_point at;
  };
  std::function<void(const v1::Presence&)> Keep() {
    return [this](const v1::Presence& newest) {
      std::lock_guard lock(mutex_);
      sent_.push_back({newest.colour_rgb(), Clock::now()});
      came_.notify_all();
    };
  }
  bool WaitForColour(uint32_t colour) {
    std::unique_lock lock(mutex_);
    return came_.wait_for(lock, std::chrono::seconds(10),
                          [&] { return !sent_.empty() && sent_.back().colour == colour; });
  }
  std::vector<Sent> sent() {
    std::lock_guard lock(mutex_);
    return sent_;
  }

  std::mutex mutex_;
  std::condition_variable came_;
  std::vector<Sent> sent_;
};

TEST_F(NewestSenderTest, TheFirstGoesAtOnceAndTheLastAlways) {
  constexpr milliseconds kInterval{40};
  NewestSender sender(kInterval, Keep());
  const auto start = Clock::now();
  sender.Offer(Selecting(1));
  ASSERT_TRUE(WaitForColour(1));
  EXPECT_LT(sent()[0].at - start, std::chrono::seconds(1));
  uint32_t count = 1;
  while (Clock::now() - start < milliseconds(400)) {
    sender.Offer(Selecting(static_cast<int>(++count)));
    std::this_thread::sleep_for(milliseconds(1));
  }
  ASSERT_TRUE(WaitForColour(count)) << "the newest arrives";
  const std::vector<Sent> all = sent();
  const auto took = all.back().at - all.front().at;
  EXPECT_LE(all.size(), static_cast<size_t>(took / kInterval) + 2) << "of " << count << " offered";
  EXPECT_GE(all.size(), 3u);
  for (size_t i = 1; i < all.size(); ++i) {
    EXPECT_GT(all[i].colour, all[i - 1].colour);
    EXPECT_GE(all[i].at - all[i - 1].at, kInterval) << i;
  }
}

TEST_F(NewestSenderTest, WhatWasSentLastIsNotSentAgain) {
  NewestSender sender(milliseconds(1), Keep());
  for (const int colour : {1, 1, 2, 2, 1}) {
    sender.Offer(Selecting(colour));
    ASSERT_TRUE(WaitForColour(static_cast<uint32_t>(colour)));
    std::this_thread::sleep_for(milliseconds(10));
  }
  EXPECT_EQ(sent().size(), 3u);
}

TEST_F(NewestSenderTest, OfferingNeverWaitsForASendThatDoes) {
  std::promise<void> go_on;
  auto may_go_on = go_on.get_future().share();
  auto keep = Keep();
  NewestSender sender(milliseconds(1), [&](const v1::Presence& newest) {
    keep(newest);
    may_go_on.wait();
  });
  sender.Offer(Selecting(1));
  ASSERT_TRUE(WaitForColour(1));
  for (int i = 2; i <= 10'000; ++i) sender.Offer(Selecting(i));
  EXPECT_EQ(sent().size(), 1u);
  go_on.set_value();
  ASSERT_TRUE(WaitForColour(10'000));
  EXPECT_EQ(sent().size(), 2u) << "nothing queues";
  sender.Close();
  sender.Offer(Selecting(3));
  std::this_thread::sleep_for(milliseconds(20));
  EXPECT_EQ(sent().size(), 2u) << "nothing is sent after the end";
}

}  // namespace
}  // namespace penumbra::testing
