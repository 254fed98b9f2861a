// Jobs that wait for a thread: what people look at comes first.
//
//   JobQueue jobs(pool.lane(1));
//   jobs.Add(channel);   // channel->RunJob() on one of the lane's threads
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "render/engine/worker_pool.h"

namespace penumbra {

class Channel;

// A thread that is free takes the waiting channel of the greatest viewed_share(), as it is at that
// moment, and of equals the one that has waited longest. Bounded by the channels there are, each of
// which waits at most once.
class JobQueue {
 public:
  explicit JobQueue(WorkerPool::Lane& lane) : lane_(lane) {}

  void Add(std::shared_ptr<Channel> channel);

 private:
  void RunFirst();

  WorkerPool::Lane& lane_;
  std::mutex mutex_;
  std::vector<std::shared_ptr<Channel>> waiting_;  // in the order of their coming
};

}  // namespace penumbra
