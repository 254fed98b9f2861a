#include "server/session/session.h"

#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "proto/convert/status_convert.h"
#include "render/scene/field_error.h"
#include "server/session/wire_message.h"

namespace penumbra {
namespace {

bool AllowsUpdates(const v1::SessionResponse& response) {
  return response.has_subscribe_result() || response.has_subscribe_each_result();
}

}  // namespace

Session::Session(const SessionServices& services, const Caller& caller, std::function<void()> wake,
                 LetGo let_go)
    : services_(services),
      caller_(caller),
      wake_(std::move(wake)),
      let_go_(std::move(let_go)),
      record_(services.ledger.Open()),
      viewer_(std::to_string(record_->number())),
      mirror_(services.updates) {}

std::shared_ptr<Session> Session::Create(const SessionServices& services, const Caller& caller,
                                         std::function<void()> wake, LetGo let_go) {
  ++services.counters.open_sessions;
  return std::shared_ptr<Session>(
      new Session(services, caller, std::move(wake), std::move(let_go)));
}

Session::~Session() {
  services_.counters.open_subscriptions -= feeds_.size();
  --services_.counters.open_sessions;
}

Session::Output Session::Next() {
  std::lock_guard lock(mutex_);
  if (closed_) return {};
  Output output = Choose();
  if (output.message) handed_over_at_ = std::chrono::steady_clock::now();
  return output;
}

Session::Output Session::Choose() {
  // The mirror is told of what a reply builds on before the reply.
  const bool reply_is_due = !replies_.empty() && replies_.front()->is_ready &&
                            !mirror_.in_update() && MirrorAllows(*replies_.front());
  if (reply_is_due) {
    const auto reply = std::move(replies_.front());
    replies_.pop_front();
    if (AllowsUpdates(reply->response)) --unsent_subscribe_results_;
    is_welcome_ = is_welcome_ || reply->response.has_welcome();
    return {.message = ToBytes(reply->response), .end = {}};
  }
  SubscriptionFeed* const feed = end_ || unsent_subscribe_results_ > 0 ? nullptr : DueFeed();
  if (is_welcome_) {
    if (auto news = NextNews(feed != nullptr)) return {.message = std::move(news), .end = {}};
  }
  if (end_ && replies_.empty()) return {.message = {}, .end = end_};
  if (!feed) return {};
  if (const auto skipped = feed->TakeSkipped(std::chrono::steady_clock::now())) {
    v1::SessionResponse response;
    response.mutable_updates_skipped()->set_subscription_id(feed->id());
    response.mutable_updates_skipped()->set_total(*skipped);
    return {.message = ToBytes(response), .end = {}};
  }
  last_fed_ = feed->id();
  auto message = feed->NextMessage();
  if (message.ends_update) record_->CountUpdate(message.skipped_updates);
  return {.message = std::move(message.bytes), .end = {}};
}

bool Session::MirrorAllows(const Reply& reply) {
  if (!mirrors_scene_) return true;
  if (reply.scene) return mirror_.CanTellOwnCommit(reply.scene);
  return reply.revision <= mirror_.told_revision();
}

// Of the scene, of its principal's computing, and of who is in the scene.
std::optional<grpc::ByteBuffer> Session::NextNews(bool is_feed_due) {
  if (mirrors_scene_ && mirror_.HasUpdate()) return mirror_.NextUpdate();
  if (told_over_compute_ == compute_.ok()) return ComputeNews();
  // In a crowd there is always something new: artifacts have every other turn.
  if (std::exchange(told_presence_last_, false) && is_feed_due) return std::nullopt;
  v1::SessionResponse response;
  if (participant_id_.empty() || !std::exchange(has_presence_news_, false)) return std::nullopt;
  const bool is_new =
      room_->ChangesSince(told_presence_, participant_id_, *response.mutable_presence_update());
  has_presence_news_ = room_->HasMore(told_presence_);
  if (!is_new) return std::nullopt;
  told_presence_last_ = true;
  return ToBytes(response);
}

void Session::OnSent() {
  std::lock_guard lock(mutex_);
  handed_over_at_.reset();
}

void Session::EndIfStalled(std::chrono::steady_clock::time_point now) {
  FeedTable feeds;
  {
    std::lock_guard lock(mutex_);
    const std::chrono::seconds patience{services_.limits.max_stall_seconds};
    if (closed_ || !handed_over_at_ || now - *handed_over_at_ < patience) return;
    handed_over_at_.reset();
    feeds.swap(feeds_);
  }
  for (auto& [id, feed] : feeds) Release(std::move(feed));
  const auto reason = FieldError(
      absl::StatusCode::kResourceExhausted, "SLOW_CONSUMER", "",
      absl::StrCat("found nothing taken for ", services_.limits.max_stall_seconds,
                   " s, need a client that reads: resume from the revision that it has"));
  End(reason);
  let_go_(reason);
}

void Session::OnPresenceChanged() {
  {
    std::lock_guard lock(mutex_);
    has_presence_news_ = true;
  }
  wake_();
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
    replies_.push_back(std::make_shared<Reply>(Reply{std::move(response), std::move(scene)}));
  }
  wake_();
}

void Session::End(const absl::Status& status) {
  {
    std::lock_guard lock(mutex_);
    if (end_) return;
    end_ = status;
  }
  record_->End(status);
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
  if (!participant_id_.empty()) room_->Leave(participant_id_);
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
  record_->CountSubscriptions(-1);
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
