#include "render/engine/worker_pool.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace penumbra {

WorkerPool::WorkerPool(const std::vector<int>& bounds) : lanes_(bounds.size()) {
  for (size_t i = 0; i < bounds.size(); ++i) {
    lanes_[i].pool_ = this;
    lanes_[i].bound_ = bounds[i];
  }
  const int thread_count = std::accumulate(bounds.begin(), bounds.end(), 0);
  threads_.reserve(thread_count);
  for (int i = 0; i < thread_count; ++i) threads_.emplace_back([this] { Work(); });
}

thread_local std::vector<WorkerPool::Next> WorkerPool::next_;

void WorkerPool::Lane::Post(Task task) {
  {
    std::lock_guard lock(pool_->mutex_);
    if (pool_->stopped_) return;
    tasks_.push_back(std::move(task));
  }
  pool_->posted_.notify_one();
}

void WorkerPool::Lane::PostNext(Task task) { next_.push_back({this, std::move(task)}); }

void WorkerPool::Stop() {
  std::vector<std::deque<Task>> dropped(lanes_.size());
  {
    std::lock_guard lock(mutex_);
    stopped_ = true;
    for (size_t i = 0; i < lanes_.size(); ++i) dropped[i].swap(lanes_[i].tasks_);
  }
  dropped.clear();
  posted_.notify_all();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
  for (Lane& lane : lanes_) lane.tasks_.clear();  // what the last tasks posted to be next
}

WorkerPool::Lane* WorkerPool::FindWork() {
  const auto found =
      std::find_if(lanes_.begin(), lanes_.end(), [](const Lane& lane) { return lane.CanRun(); });
  return found == lanes_.end() ? nullptr : &*found;
}

void WorkerPool::Work() {
  std::unique_lock lock(mutex_);
  while (!stopped_) {
    Lane* const lane = FindWork();
    if (!lane) {
      posted_.wait(lock);
      continue;
    }
    Task task = std::move(lane->tasks_.front());
    lane->tasks_.pop_front();
    ++lane->running_;
    // What is left was perhaps posted to be a thread's next, or waited for room in its lane.
    const bool is_more = FindWork() != nullptr;
    lock.unlock();
    if (is_more) posted_.notify_one();
    task();
    task = nullptr;  // what it holds dies here, not under the lock
    lock.lock();
    --lane->running_;
    for (Next& next : next_) next.lane->tasks_.push_back(std::move(next.task));
    next_.clear();
  }
}

}  // namespace penumbra
