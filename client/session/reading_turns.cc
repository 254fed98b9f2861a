#include "client/session/reading_turns.h"

#include <utility>

namespace penumbra {

ReadingTurns::ReadingTurns(std::function<bool()> read_one) : read_one_(std::move(read_one)) {}

ReadingTurns::~ReadingTurns() { Join(); }

void ReadingTurns::Start() {
  for (int i = 0; i <= kMaxJobs; ++i) threads_.emplace_back([this] { Run(); });
}

void ReadingTurns::Join() {
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

void ReadingTurns::Post(std::function<void()> job) {
  std::lock_guard lock(mutex_);
  jobs_.push_back(std::move(job));
}

void ReadingTurns::PostAtOnce(std::function<void()> job) {
  Post(std::move(job));
  turn_.notify_one();
}

void ReadingTurns::Run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    if (MayRunJob()) {
      std::function<void()> job = std::move(jobs_.front());
      jobs_.pop_front();
      ++running_jobs_;
      lock.unlock();
      job();
      job = nullptr;
      lock.lock();
      --running_jobs_;
    } else if (has_ended_) {
      return;
    } else if (!has_reader_) {
      Read(lock);
    } else {
      turn_.wait(lock);
    }
  }
}

void ReadingTurns::Read(std::unique_lock<std::mutex>& lock) {
  has_reader_ = true;
  while (!has_ended_ && !MayRunJob()) {
    lock.unlock();
    const bool more = read_one_();
    lock.lock();
    has_ended_ = !more;
  }
  has_reader_ = false;
  if (has_ended_) {
    turn_.notify_all();
  } else {
    turn_.notify_one();
  }
}

}  // namespace penumbra
