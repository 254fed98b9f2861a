#include "client/session/newest_sender.h"

#include <utility>

namespace penumbra {

NewestSender::NewestSender(std::chrono::milliseconds interval,
                           std::function<void(const v1::Presence& newest)> send)
    : interval_(interval),
      send_(std::move(send)),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

void NewestSender::Offer(v1::Presence presence) {
  std::lock_guard lock(mutex_);
  waiting_ = std::move(presence);
  offered_.notify_one();
}

void NewestSender::Close() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

void NewestSender::Run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (offered_.wait(lock, stop, [this] { return waiting_.has_value(); })) {
    if (stop.stop_requested()) return;
    const v1::Presence newest = *std::exchange(waiting_, std::nullopt);
    if (std::string bytes = newest.SerializeAsString(); bytes != std::exchange(sent_, bytes)) {
      lock.unlock();
      send_(newest);
      lock.lock();
      // Not the time it takes to send: what comes meanwhile waits no longer than it must.
      offered_.wait_for(lock, stop, interval_, [] { return false; });
    }
  }
}

}  // namespace penumbra
