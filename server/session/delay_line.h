// Runs tasks a fixed time after they were posted, on a thread of its own.
//
//   DelayLine line(std::chrono::milliseconds(3));
//   line.Post([weak] { if (auto stream = weak.lock()) stream->PublishHeldBack(); });
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace penumbra {

class DelayLine {
 public:
  explicit DelayLine(std::chrono::microseconds delay);
  // Drops the tasks that are not due.
  ~DelayLine();
  DelayLine(const DelayLine&) = delete;
  DelayLine& operator=(const DelayLine&) = delete;

  void Post(std::function<void()> task);

 private:
  struct Entry {
    std::chrono::steady_clock::time_point due;
    std::function<void()> task;
  };

  void Loop();

  const std::chrono::microseconds delay_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Entry> entries_;  // the first is due first, since all wait for the same time
  bool is_ending_ = false;
  std::thread thread_;
};

}  // namespace penumbra
