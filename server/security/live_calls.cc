#include "server/security/live_calls.h"

#include <utility>
#include <vector>

namespace penumbra {
namespace {

// For a client to read how its stream ended.
constexpr std::chrono::seconds kTimeToEnd{2};

}  // namespace

void LiveCall::Finish() {
  std::lock_guard lock(mutex_);
  context_ = nullptr;
}

absl::Status LiveCall::StillAllowed() {
  std::lock_guard lock(mutex_);
  return check_();
}

void LiveCall::Sweep(std::chrono::steady_clock::time_point now) {
  std::lock_guard lock(mutex_);
  if (!context_) return;
  if (told_) {
    if (now - *told_ >= kTimeToEnd) context_->TryCancel();
    return;
  }
  const absl::Status status = check_();
  if (status.ok()) return;
  told_ = now;
  if (end_) {
    end_(status);
  } else {
    context_->TryCancel();
  }
}

std::shared_ptr<LiveCall> LiveCalls::Add(LiveCall::Check check, LiveCall::End end,
                                         grpc::CallbackServerContext* context) {
  auto call = std::make_shared<LiveCall>(std::move(check), std::move(end), context);
  std::lock_guard lock(mutex_);
  calls_.push_back(call);
  return call;
}

void LiveCalls::Sweep(std::chrono::steady_clock::time_point now) {
  std::vector<std::shared_ptr<LiveCall>> calls;
  {
    std::lock_guard lock(mutex_);
    std::erase_if(calls_, [](const auto& weak) { return weak.expired(); });
    for (const auto& weak : calls_) {
      if (auto call = weak.lock()) calls.push_back(std::move(call));
    }
  }
  for (const auto& call : calls) call->Sweep(now);
}

}  // namespace penumbra
