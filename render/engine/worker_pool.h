// Threads that run tasks of one or more kinds, each kind in the order of its posting and with a
// bound on how many of it run at a time.
//
//   WorkerPool pool({2, 2});
//   WorkerPool::Lane& jobs = pool.lane(1);
//   jobs.Post([job] { job->Run(); });
//
// There is a thread for every task that may run, so a lane whose tasks block holds up no other. All
// lanes share the threads, so that a thread whose job ends can go on with what follows from it: to
// wake another costs as much as the rest of a small answer's way (docs/performance.md).
//
// The queues have no bound of their own: those who post have at most one task waiting each.
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
  using Task = std::function<void()>;

  class Lane {
   public:
    // Tasks posted after Stop are dropped.
    void Post(Task task);
    // The same once the task that posts it, one of this pool, has ended: no other thread can take
    // it before that one looks for work.
    void PostNext(Task task);

   private:
    friend class WorkerPool;

    bool CanRun() const { return !tasks_.empty() && running_ < bound_; }

    WorkerPool* pool_ = nullptr;
    int bound_ = 0;
    int running_ = 0;
    std::deque<Task> tasks_;
  };

  // `bounds[i]`  tasks of lane i that may run at a time; a thread that is free looks for a task in
  //              the lanes in their order
  explicit WorkerPool(const std::vector<int>& bounds);
  ~WorkerPool() { Stop(); }
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  Lane& lane(size_t index) { return lanes_[index]; }

  // Drops the tasks that have not begun and waits for those that have. Not from a task.
  void Stop();

 private:
  void Work();
  Lane* FindWork();  // with the lock held

  // What the task that runs on this thread has posted to be next.
  struct Next {
    Lane* lane;
    Task task;
  };
  static thread_local std::vector<Next> next_;

  std::mutex mutex_;
  std::condition_variable posted_;
  std::vector<Lane> lanes_;
  bool stopped_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace penumbra
