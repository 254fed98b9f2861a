// Threads that run tasks in the order of their posting.
//
//   WorkerPool runners(2);
//   runners.Post([channel] { channel->RunJob(); });
//
// The queue has no bound of its own: those who post have at most one task waiting each.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace penumbra {

class WorkerPool {
 public:
  explicit WorkerPool(int thread_count);
  ~WorkerPool() { Stop(); }
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  // Tasks posted after Stop are dropped.
  void Post(std::function<void()> task);

  // Drops the tasks that have not begun and waits for those that have. Not from a task.
  void Stop();

 private:
  void Work();

  std::mutex mutex_;
  std::condition_variable posted_;
  std::deque<std::function<void()>> tasks_;
  bool stopped_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace penumbra
