#include "client/session/reading_turns.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <future>
#include <mutex>
#include <vector>

namespace penumbra {
namespace {

// A stream that a test feeds by hand.
class Stream {
 public:
  void Put(int message) {
    std::lock_guard lock(mutex_);
    messages_.push_back(message);
    changed_.notify_all();
  }
  int Take() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !messages_.empty(); });
    const int message = messages_.front();
    messages_.pop_front();
    return message;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<int> messages_;
};

constexpr int kEnd = -1;

TEST(ReadingTurnsTest, ReadsInOrderAndRunsEveryJobBeforeItEnds) {
  Stream stream;
  std::vector<int> read;
  std::atomic<int> jobs = 0;
  ReadingTurns* self = nullptr;
  ReadingTurns turns([&] {
    const int message = stream.Take();
    if (message == kEnd) return false;
    read.push_back(message);
    self->Post([&] { ++jobs; });
    return true;
  });
  self = &turns;
  turns.Start();
  for (int i = 0; i < 1000; ++i) stream.Put(i);
  stream.Put(kEnd);
  turns.Join();
  ASSERT_EQ(read.size(), 1000u);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(read[i], i);
  EXPECT_EQ(jobs, 1000);
}

TEST(ReadingTurnsTest, GoesOnReadingWhileJobsAreStuck) {
  Stream stream;
  std::promise<void> gate, seen;
  const auto open = gate.get_future().share();
  std::atomic<int> jobs = 0;
  ReadingTurns* self = nullptr;
  ReadingTurns turns([&] {
    const int message = stream.Take();
    if (message == kEnd) return false;
    if (message == 1) {
      self->Post([&] {
        open.wait();
        ++jobs;
      });
    } else {
      seen.set_value();
    }
    return true;
  });
  self = &turns;
  turns.Start();
  const int stuck = 3 * ReadingTurns::kMaxJobs;
  for (int i = 0; i < stuck; ++i) stream.Put(1);
  stream.Put(2);
  EXPECT_EQ(seen.get_future().wait_for(std::chrono::seconds(10)), std::future_status::ready);
  EXPECT_EQ(jobs, 0);
  gate.set_value();
  stream.Put(kEnd);
  turns.Join();
  EXPECT_EQ(jobs, stuck);
}

TEST(ReadingTurnsTest, AJobStartsThoughNoFurtherMessageComes) {
  Stream stream;
  std::promise<void> ran;
  ReadingTurns* self = nullptr;
  ReadingTurns turns([&] {
    if (stream.Take() == kEnd) return false;
    self->Post([&] { ran.set_value(); });
    return true;
  });
  self = &turns;
  turns.Start();
  stream.Put(1);
  EXPECT_EQ(ran.get_future().wait_for(std::chrono::seconds(10)), std::future_status::ready);
  stream.Put(kEnd);
}

TEST(ReadingTurnsTest, EndsWithoutHavingStarted) {
  ReadingTurns turns([] { return false; });
  turns.Join();
}

}  // namespace
}  // namespace penumbra
