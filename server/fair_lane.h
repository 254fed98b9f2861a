// A lane of a pool in which parties take turns, however many tasks each has waiting: whoever comes
// waits for one task of each of the others, and for those that run.
//
//   WorkerPool pool({8, 2});
//   FairLane histories(pool.lane(1));
//   histories.Post("ana", [session] { session->Greet(); });
#pragma once

#include <deque>
#include <map>
#include <mutex>
#include <string>

#include "render/engine/worker_pool.h"

namespace penumbra {

// Any thread may use it.
class FairLane {
 public:
  // `lane` outlives it, and nobody else posts to it.
  explicit FairLane(WorkerPool::Lane& lane) : lane_(lane) {}
  FairLane(const FairLane&) = delete;
  FairLane& operator=(const FairLane&) = delete;

  // Tasks of one party are begun in the order of their posting. Those posted after Stop are
  // dropped.
  void Post(const std::string& party, WorkerPool::Task task);

  // Drops the tasks that have not begun. To be called once the pool has stopped.
  void Stop();

 private:
  void RunNext();

  WorkerPool::Lane& lane_;
  std::mutex mutex_;                                             // guards all below
  std::map<std::string, std::deque<WorkerPool::Task>> waiting_;  // by party; none is empty
  std::string last_;                                             // whose turn it was
  bool stopped_ = false;
};

}  // namespace penumbra
