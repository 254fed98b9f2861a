// What a session is told of what it may not have now.

#include <algorithm>
#include <utility>

#include "penumbra/v1/session.pb.h"
#include "proto/convert/status_convert.h"
#include "server/session/session.h"
#include "server/session/wire_message.h"

namespace penumbra {

// Whoever is to wait is told so at once, and not after what waits for the disk.
void Session::HurryReply(const Reply& reply) {
  const auto first = replies_.begin() + (is_welcome_ || replies_.empty() ? 0 : 1);
  const auto is_it = [&](const auto& other) { return other.get() == &reply; };
  const auto place = std::find_if(first, replies_.end(), is_it);
  if (place == replies_.end()) return;
  // Those that are ready before it stay before it.
  const auto waits = [](const auto& other) { return !other->is_ready; };
  std::rotate(std::find_if(first, place, waits), place, place + 1);
}

// However often that changes, the client has one message of it to read: the newest.
void Session::TellOfCompute() {
  const absl::Status status = services_.quotas.CheckCompute(caller_.identity().name);
  {
    std::lock_guard lock(mutex_);
    if (!is_welcome_ || compute_.ok() == status.ok()) return;
    compute_ = status;
  }
  if (!status.ok()) record_->NoteOverQuota(status);
  wake_();
}

// With the lock held.
grpc::ByteBuffer Session::ComputeNews() {
  told_over_compute_ = !compute_.ok();
  v1::SessionResponse response;
  v1::ComputeQuota& quota = *response.mutable_compute_quota();
  if (told_over_compute_) *quota.mutable_error() = ToProto(compute_);
  return ToBytes(response);
}

}  // namespace penumbra
