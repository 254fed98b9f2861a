// Those who wait for something that is done for all of them at once, by one task at a time.
//
//   if (queue.Add(scene)) lane.Post(task);
//   task: Write(queue.Take()); if (queue.PassOn()) lane.Post(task);
#pragma once

#include <mutex>
#include <utility>
#include <vector>

namespace penumbra {

// Any thread may use it.
template <typename T>
class WriteQueue {
 public:
  // True: there is no task that is going to take it, and one has to be posted.
  [[nodiscard]] bool Add(T waiting) {
    std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(waiting));
    return !std::exchange(has_task_, true);
  }
  // All that wait, for the task that there is.
  std::vector<T> Take() {
    std::lock_guard lock(mutex_);
    return std::exchange(waiting_, {});
  }
  // The task is done with what it took. True: others wait by now, and another has to be posted.
  [[nodiscard]] bool PassOn() {
    std::lock_guard lock(mutex_);
    return has_task_ = !waiting_.empty();
  }

 private:
  std::mutex mutex_;
  std::vector<T> waiting_;
  bool has_task_ = false;
};

}  // namespace penumbra
