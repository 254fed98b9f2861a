#include "client/cli/shadow_board.h"

#include <algorithm>
#include <utility>

namespace penumbra {

absl::Status ShadowBoard::Follow(RemoteEngine& engine, const std::string& scene_id,
                                 const std::vector<ArtifactSpec>& specs) {
  {
    std::lock_guard lock(mutex_);
    entries_.resize(specs.size());
  }
  for (size_t i = 0; i < specs.size(); ++i) {
    auto subscription = engine.SubscribeMeasured(
        scene_id, specs[i], [this, i](const ArtifactUpdate& update, const UpdateTraffic& traffic) {
          Receive(i, update, traffic);
        });
    if (!subscription.ok()) return subscription.status();
    subscriptions_.push_back(*std::move(subscription));
  }
  return absl::OkStatus();
}

void ShadowBoard::Receive(size_t index, const ArtifactUpdate& update,
                          const UpdateTraffic& traffic) {
  std::lock_guard lock(mutex_);
  entries_[index] = {.update = update, .is_here = true};
  received_.updates += 1;
  received_.bytes += traffic.bytes;
  if (update.revision >= awaited_) {
    if (received_.first_ms == 0.0) received_.first_ms = traffic.received_ms;
    received_.last_ms = traffic.received_ms;
  }
  changed_.notify_all();
}

bool ShadowBoard::IsSettled(Revision revision) const {
  return std::ranges::all_of(entries_, [revision](const Entry& entry) {
    if (!entry.is_here) return false;
    if (!entry.update.status.ok()) return true;
    return entry.update.revision >= revision && entry.update.artifact->header.is_final;
  });
}

absl::StatusOr<ReceivedUpdates> ShadowBoard::WaitFor(Revision revision, std::stop_token stop) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, stop, [&] { return IsSettled(revision); });
  if (!IsSettled(revision)) return absl::CancelledError("interrupted");
  for (const Entry& entry : entries_) {
    if (!entry.update.status.ok()) return entry.update.status;
  }
  awaited_ = revision + 1;
  return std::exchange(received_, {});
}

Shadows ShadowBoard::shadows() const {
  std::lock_guard lock(mutex_);
  Shadows shadows;
  for (const Entry& entry : entries_) shadows.push_back(entry.update.artifact);
  return shadows;
}

}  // namespace penumbra
