#include "render/engine/job_queue.h"

#include <algorithm>
#include <utility>

#include "render/engine/channel.h"

namespace penumbra {

void JobQueue::Add(std::shared_ptr<Channel> channel) {
  {
    std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(channel));
  }
  lane_.Post([this] { RunFirst(); });
}

void JobQueue::RunFirst() {
  std::shared_ptr<Channel> channel;
  {
    std::lock_guard lock(mutex_);
    const auto first = std::max_element(
        waiting_.begin(), waiting_.end(),
        [](const auto& a, const auto& b) { return a->viewed_share() < b->viewed_share(); });
    channel = std::move(*first);
    waiting_.erase(first);
  }
  channel->RunJob();
}

}  // namespace penumbra
