#include "render/engine/subscriber.h"

#include <utility>

namespace penumbra {

Subscriber::Subscriber(ArtifactCallback callback, WorkerPool::Lane& deliveries,
                       EngineCounters& counters)
    : deliveries_(deliveries), counters_(counters), callback_(std::move(callback)) {}

void Subscriber::Offer(const ArtifactUpdate& update) {
  if (Put(update)) deliveries_.Post([self = shared_from_this()] { self->Deliver(); });
}

void Subscriber::OfferNext(const ArtifactUpdate& update) {
  if (Put(update)) deliveries_.PostNext([self = shared_from_this()] { self->Deliver(); });
}

bool Subscriber::Put(const ArtifactUpdate& update) {
  std::lock_guard lock(mutex_);
  if (closed_) return false;
  waiting_ = update;
  return !std::exchange(scheduled_, true);
}

void Subscriber::Close() {
  ArtifactCallback dead;  // destroyed without the lock: it may own anything
  std::unique_lock lock(mutex_);
  closed_ = true;
  waiting_.reset();
  if (running_on_ == std::this_thread::get_id()) return;
  returned_.wait(lock, [this] { return running_on_ == std::thread::id(); });
  dead.swap(callback_);
  lock.unlock();
}

void Subscriber::Deliver() {
  ArtifactCallback dead;
  std::unique_lock lock(mutex_);
  if (!waiting_) {
    scheduled_ = false;
    return;
  }
  const ArtifactUpdate update = *std::exchange(waiting_, std::nullopt);
  running_on_ = std::this_thread::get_id();
  lock.unlock();

  callback_(update);
  ++counters_.callbacks_run;

  lock.lock();
  running_on_ = std::thread::id();
  if (closed_) dead.swap(callback_);
  // Posted anew rather than looped: other subscribers get their turn.
  scheduled_ = waiting_.has_value();
  if (scheduled_) deliveries_.PostNext([self = shared_from_this()] { self->Deliver(); });
  returned_.notify_all();
  lock.unlock();
}

}  // namespace penumbra
