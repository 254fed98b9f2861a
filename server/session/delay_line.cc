#include "server/session/delay_line.h"

#include <utility>

namespace penumbra {

DelayLine::DelayLine(std::chrono::microseconds delay)
    : delay_(delay), thread_([this] { Loop(); }) {}

DelayLine::~DelayLine() {
  {
    std::lock_guard lock(mutex_);
    is_ending_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void DelayLine::Post(std::function<void()> task) {
  bool was_empty = false;
  {
    std::lock_guard lock(mutex_);
    was_empty = entries_.empty();
    entries_.push_back({std::chrono::steady_clock::now() + delay_, std::move(task)});
  }
  // Otherwise the thread wakes up for the first entry anyway.
  if (was_empty) changed_.notify_one();
}

void DelayLine::Loop() {
  std::unique_lock lock(mutex_);
  while (!is_ending_) {
    if (entries_.empty()) {
      changed_.wait(lock);
    } else if (const auto due = entries_.front().due; std::chrono::steady_clock::now() < due) {
      changed_.wait_until(lock, due);
    } else {
      auto task = std::move(entries_.front().task);
      entries_.pop_front();
      lock.unlock();
      task();
      lock.lock();
    }
  }
}

}  // namespace penumbra
