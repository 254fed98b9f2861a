// One subscription's mailbox: it holds the newest update that its callback has not seen, and has
// the callback called with it, one call at a time, on a thread of the pool.
//
// A slow callback misses updates that newer ones replace; it holds up nobody and costs no memory.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "render/engine/engine.h"
#include "render/engine/engine_statistics.h"
#include "render/engine/worker_pool.h"

namespace penumbra {

class Subscriber : public std::enable_shared_from_this<Subscriber> {
 public:
  // Both must live until Close returns or the pool has stopped.
  Subscriber(ArtifactCallback callback, WorkerPool::Lane& deliveries, EngineCounters& counters);

  // Replaces what waits. Never blocks on the callback.
  void Offer(const ArtifactUpdate& update);
  // The same, as the last thing that a task of the pool does: its thread goes on with the callback.
  void OfferNext(const ArtifactUpdate& update);

  // No call begins after this returns, and none is running: except when it is the callback itself
  // that closes its subscription; then the call that runs is the last one.
  void Close();

 private:
  // Whether a delivery is to be posted.
  bool Put(const ArtifactUpdate& update);
  void Deliver();

  WorkerPool::Lane& deliveries_;
  EngineCounters& counters_;
  std::mutex mutex_;
  std::condition_variable returned_;
  ArtifactCallback callback_;
  std::optional<ArtifactUpdate> waiting_;
  bool scheduled_ = false;  // a task of the pool's is going to deliver, or is delivering
  bool closed_ = false;
  std::thread::id running_on_;  // none: the callback is not running
};

}  // namespace penumbra
