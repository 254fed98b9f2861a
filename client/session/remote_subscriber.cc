#include "client/session/remote_subscriber.h"

#include <algorithm>
#include <utility>

namespace penumbra {

absl::StatusOr<bool> RemoteSubscriber::Receive(const v1::ArtifactUpdate& message, double now_ms,
                                               const std::function<double(Revision)>& heard_ms) {
  ++incoming_.messages;
  incoming_.bytes += message.ByteSizeLong();
  auto update = assembler_->Add(message);
  if (!update.ok()) return update.status();
  if (!update->has_value()) return false;

  std::lock_guard lock(mutex_);
  waiting_traffic_.messages += incoming_.messages;
  waiting_traffic_.bytes += incoming_.bytes;
  waiting_traffic_.received_ms = now_ms;
  waiting_traffic_.since_ms = std::max(asked_ms_, heard_ms((*update)->revision));
  incoming_ = {};
  waiting_consumed_.acknowledged_sequence = assembler_->sequence();
  ++waiting_consumed_.updates;
  return Offer(**std::move(update));
}

void RemoteSubscriber::Restart(uint64_t link) {
  assembler_.emplace(limits_);
  incoming_ = {};
  std::lock_guard lock(mutex_);
  waiting_consumed_ = {.link = link};
}

bool RemoteSubscriber::ReceiveEnd(const absl::Status& reason) {
  std::lock_guard lock(mutex_);
  waiting_traffic_.is_last = true;
  return Offer({.revision = newest_revision_, .status = reason, .artifact = nullptr});
}

bool RemoteSubscriber::Offer(ArtifactUpdate update) {
  if (is_closed_) return false;
  newest_revision_ = std::max(newest_revision_, update.revision);
  waiting_ = std::move(update);
  return !std::exchange(is_scheduled_, true);
}

void RemoteSubscriber::Deliver(const std::function<void(const Consumed&)>& consumed) {
  std::unique_lock lock(mutex_);
  while (waiting_ && !is_closed_) {
    const ArtifactUpdate update = *std::exchange(waiting_, std::nullopt);
    const UpdateTraffic traffic = std::exchange(waiting_traffic_, {});
    const Consumed done = std::exchange(waiting_consumed_, {.link = waiting_consumed_.link});
    caller_ = std::this_thread::get_id();
    lock.unlock();
    callback_(update, traffic);
    lock.lock();
    caller_ = {};
    idle_.notify_all();
    if (is_closed_) break;
    lock.unlock();
    if (done.updates > 0) consumed(done);
    lock.lock();
  }
  is_scheduled_ = false;
}

void RemoteSubscriber::Close() {
  std::unique_lock lock(mutex_);
  is_closed_ = true;
  waiting_.reset();
  if (caller_ == std::this_thread::get_id()) return;
  idle_.wait(lock, [this] { return caller_ == std::thread::id(); });
  callback_ = nullptr;
}

}  // namespace penumbra
