#include "server/session/session.h"

#include <string>
#include <utility>
#include <vector>

#include "proto/convert/status_convert.h"
#include "server/session/wire_message.h"

namespace penumbra {

Session::Session(const SessionServices& services, const Caller& caller, std::function<void()> wake)
    : services_(services),
      caller_(caller),
      wake_(std::move(wake)),
      viewer_(std::to_string(++services.counters.sessions_made)),
      mirror_(services.limits.max_message_bytes) {}

std::shared_ptr<Session> Session::Create(const SessionServices& services, const Caller& caller,
                                         std::function<void()> wake) {
  ++services.counters.open_sessions;
  return std::shared_ptr<Session>(new Session(services, caller, std::move(wake)));
}

Session::~Session() {
  services_.counters.open_subscriptions -= feeds_.size();
  --services_.counters.open_sessions;
}

Session::Output Session::Next() {
  std::lock_guard lock(mutex_);
  if (closed_) return {};
  // The mirror is told of what a reply builds on before the reply.
  const bool reply_is_due = !replies_.empty() && !mirror_.in_update() &&
                            (!replies_.front().scene || !mirrors_scene_ ||
                             mirror_.CanTellOwnCommit(replies_.front().scene));
  if (reply_is_due) {
    Reply reply = std::move(replies_.front());
    replies_.pop_front();
    return {.message = ToBytes(reply.response), .end = {}};
  }
  if (mirrors_scene_ && mirror_.HasUpdate()) {
    v1::SessionResponse response;
    *response.mutable_scene_update() = mirror_.NextUpdate();
    return {.message = ToBytes(response), .end = {}};
  }
  if (end_) return {.message = {}, .end = end_};
  SubscriptionFeed* feed = DueFeed();
  if (!feed) return {};
  last_fed_ = feed->id();
  auto message = feed->NextMessage();
  if (message.ends_update) ++services_.counters.updates_sent;
  return {.message = std::move(message.bytes), .end = {}};
}

SubscriptionFeed* Session::DueFeed() {
  if (feeds_.empty()) return nullptr;
  if (const auto last = feeds_.find(last_fed_); last != feeds_.end() && last->second->in_update()) {
    return last->second.get();
  }
  auto feed = feeds_.upper_bound(last_fed_);
  for (size_t i = 0; i < feeds_.size(); ++i, ++feed) {
    if (feed == feeds_.end()) feed = feeds_.begin();
    if (feed->second->HasMessage()) return feed->second.get();
  }
  return nullptr;
}

bool Session::has_room() const {
  std::lock_guard lock(mutex_);
  return !end_ && !closed_ && replies_.size() < services_.limits.max_queued_replies;
}

bool Session::is_ending() const {
  std::lock_guard lock(mutex_);
  return end_ || closed_;
}

void Session::Push(v1::SessionResponse response, std::shared_ptr<const Scene> scene) {
  {
    std::lock_guard lock(mutex_);
    if (end_ || closed_) return;
    replies_.push_back({std::move(response), std::move(scene)});
  }
  wake_();
}

void Session::End(const absl::Status& status) {
  {
    std::lock_guard lock(mutex_);
    if (end_) return;
    end_ = status;
  }
  wake_();
}

void Session::Close() {
  FeedTable feeds;
  {
    std::lock_guard lock(mutex_);
    closed_ = true;
    replies_.clear();
    feeds.swap(feeds_);
  }
  for (auto& [id, feed] : feeds) Release(std::move(feed));
  if (!scene_id_.empty()) {
    // Gone with the scene, if that is gone.
    services_.scenes.ReportView(scene_id_, viewer_, std::nullopt).IgnoreError();
  }
}

// Without the lock: the last to let go of a stream waits for the stream's callback, which may be
// waking this session.
void Session::Release(std::unique_ptr<SubscriptionFeed> feed) {
  feed->stream().RemoveListener(this);
  feed.reset();
  --services_.counters.open_subscriptions;
}

void Session::OnScene(std::shared_ptr<const Scene> scene) {
  {
    std::lock_guard lock(mutex_);
    if (!mirrors_scene_ || closed_) return;
    mirror_.Offer(std::move(scene));
  }
  wake_();
}

void Session::OnSceneDeleted(const absl::Status& reason) {
  std::vector<uint64_t> ids;
  {
    std::lock_guard lock(mutex_);
    for (const auto& [id, feed] : feeds_) ids.push_back(id);
  }
  for (const uint64_t id : ids) {
    v1::SessionResponse response;
    response.mutable_subscription_ended()->set_subscription_id(id);
    *response.mutable_subscription_ended()->mutable_error() = ToProto(reason);
    Push(std::move(response));
  }
  End(reason);
}

}  // namespace penumbra
