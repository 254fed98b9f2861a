#include "server/fair_lane.h"

#include <utility>

namespace penumbra {

void FairLane::Post(const std::string& party, WorkerPool::Task task) {
  {
    std::lock_guard lock(mutex_);
    if (stopped_) return;
    waiting_[party].push_back(std::move(task));
  }
  lane_.Post([this] { RunNext(); });
}

void FairLane::Stop() {
  std::map<std::string, std::deque<WorkerPool::Task>> dropped;  // what they hold, without the lock
  std::lock_guard lock(mutex_);
  stopped_ = true;
  dropped.swap(waiting_);
}

// The lane has one of these for each task that waits.
void FairLane::RunNext() {
  WorkerPool::Task task;
  {
    std::lock_guard lock(mutex_);
    if (waiting_.empty()) return;  // they have been dropped
    auto next = waiting_.upper_bound(last_);
    if (next == waiting_.end()) next = waiting_.begin();
    last_ = next->first;
    task = std::move(next->second.front());
    next->second.pop_front();
    if (next->second.empty()) waiting_.erase(next);
  }
  task();
}

}  // namespace penumbra
