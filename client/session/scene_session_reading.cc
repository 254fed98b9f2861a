// The reader's half of SceneSession: what the server says.

#include <functional>
#include <string>
#include <utility>

#include "client/session/call_status.h"
#include "client/session/scene_session.h"
#include "client/session/server_connection.h"
#include "client/session/steady_clock.h"
#include "proto/convert/status_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// Updates of revisions older than these are not worth timing.
constexpr size_t kHeardRevisions = 64;

// By one request; more than servers allow. A message has room for ids that make billions of pairs.
constexpr uint64_t kMostOfEach = uint64_t{1} << 16;

absl::Status CheckSize(const v1::SubscribeEachResult& result) {
  const uint64_t pairs = static_cast<uint64_t>(result.light_ids_size()) *
                         static_cast<uint64_t>(result.receiver_ids_size());
  if (pairs <= kMostOfEach) return absl::OkStatus();
  return absl::DataLossError("the server tells of " + std::to_string(pairs) +
                             " subscriptions by one request, need at most " +
                             std::to_string(kMostOfEach));
}

std::function<void()> Teller(const RemoteEngineOptions& options, const v1::ComputeQuota& quota) {
  return [tell = options.on_compute_quota, status = FromProto(quota.error())] {
    if (tell) tell(status);
  };
}

}  // namespace

bool SceneSession::ReadOne() {
  Link& link = *link_;  // which the reader alone changes
  if (!link.stream->Read(&response_)) {
    const absl::Status ended = StatusOfEndedSession(address_, link.stream->Finish());
    if (MayResume(ended) && Reconnect(ended)) return true;
    EndAll(ended);
    return false;
  }
  Dispatch();
  if (response_.has_welcome()) {
    incarnation_ = response_.welcome().incarnation();
    Begin(link);
  }
  std::lock_guard lock(mutex_);
  is_welcome_ = is_welcome_ || response_.has_welcome();
  const bool is_awaited = !response_.has_artifact_update();
  if (is_awaited) changed_.notify_all();
  return true;
}

void SceneSession::Dispatch() {
  switch (response_.response_case()) {
    case v1::SessionResponse::kArtifactUpdate:
      Receive(response_.artifact_update());
      break;
    case v1::SessionResponse::kCommitResult:
      Receive(*response_.mutable_commit_result());
      break;
    case v1::SessionResponse::kSceneUpdate:
      Hear(response_.scene_update().revision());
      if (mirror_.Push(std::move(*response_.mutable_scene_update()))) {
        turns_.Post([this] { mirror_.CatchUp(); });
      }
      break;
    case v1::SessionResponse::kSubscribeResult:
      Receive(response_.subscribe_result());
      break;
    case v1::SessionResponse::kSubscribeEachResult:
      Receive(response_.subscribe_each_result());
      break;
    case v1::SessionResponse::kSubscriptionEnded:
      Receive(response_.subscription_ended());
      break;
    case v1::SessionResponse::kSessionError:
      Receive(response_.session_error());
      break;
    case v1::SessionResponse::kPresenceUpdate:
      Receive(response_.presence_update());
      break;
    case v1::SessionResponse::kEditControlResult:
      Receive(response_.edit_control_result());
      break;
    case v1::SessionResponse::kComputeQuota:
      return turns_.Post(Teller(connection_.options(), response_.compute_quota()));
    case v1::SessionResponse::kWelcome:
    case v1::SessionResponse::kUpdatesSkipped:
    case v1::SessionResponse::RESPONSE_NOT_SET:
      break;
  }
}

void SceneSession::Hear(Revision revision) {
  if (HeardMs(revision)) return;
  heard_ms_[revision] = NowMs();
  if (heard_ms_.size() > kHeardRevisions) heard_ms_.erase(heard_ms_.begin());
}

// Whoever has heard of a later revision knows that this one was.
std::optional<double> SceneSession::HeardMs(Revision revision) const {
  const auto found = heard_ms_.lower_bound(revision);
  if (found == heard_ms_.end()) return std::nullopt;
  return found->second;
}

void SceneSession::Receive(v1::CommitResult& result) {
  if (!result.has_error()) Hear(result.revision());
  std::lock_guard lock(mutex_);
  const auto found = commits_.find(result.commit_id());
  if (found == commits_.end()) return;
  Answer& answer = *found->second;
  answer.status = FromProto(result.error());
  answer.revision = result.revision();
  answer.is_here = true;
  if (answer.status.ok()) {
    mirror_.PushOwn(std::move(answer.delta), result.revision(), result.content_hash());
  }
  commits_.erase(found);
}

void SceneSession::Receive(const v1::SubscribeResult& result) {
  std::unique_lock lock(mutex_);
  const auto found = subscribes_.find(result.subscription_id());
  if (found == subscribes_.end()) {
    // Asked for again on this link, which the subscription's owner knows nothing of.
    const bool is_followed = subscribers_.contains(result.subscription_id());
    lock.unlock();
    if (!result.has_error()) {
      if (!is_followed) DropEach(result.subscription_id(), 1);
      return;
    }
    v1::SubscriptionEnded ended;
    ended.set_subscription_id(result.subscription_id());
    *ended.mutable_error() = result.error();
    return Receive(ended);
  }
  found->second->status = FromProto(result.error());
  found->second->is_here = true;
  if (!found->second->status.ok()) subscribers_.erase(result.subscription_id());
  subscribes_.erase(found);
}

void SceneSession::Receive(const v1::SubscribeEachResult& result) {
  if (auto status = CheckSize(result); !status.ok()) return End(status);
  std::unique_lock lock(mutex_);
  const auto found = subscribes_.find(result.first_subscription_id());
  if (found == subscribes_.end()) {
    lock.unlock();
    DropEach(result.first_subscription_id(), static_cast<uint64_t>(result.light_ids_size()) *
                                                 static_cast<uint64_t>(result.receiver_ids_size()));
    return;
  }
  found->second->status = FromProto(result.error());
  if (found->second->status.ok()) MakeSubscribers(result, *found->second);
  found->second->is_here = true;
  subscribes_.erase(found);
}

// Before the next message is read, which may be an update of one of them.
void SceneSession::MakeSubscribers(const v1::SubscribeEachResult& result, Answer& answer) {
  uint64_t id = result.first_subscription_id();
  for (const std::string& receiver_id : result.receiver_ids()) {
    for (const std::string& light_id : result.light_ids()) {
      ArtifactSpec spec{.params = answer.params,
                        .light_id = light_id,
                        .receiver_id = receiver_id,
                        .points = answer.points};
      auto callback = [each = answer.each, spec](const ArtifactUpdate& update,
                                                 const UpdateTraffic& traffic) {
        each(spec, update, traffic);
      };
      auto subscriber = std::make_shared<RemoteSubscriber>(
          id, std::move(callback), connection_.blobs().scene_limits(), mirror_.pushed_revision(),
          answer.asked_ms);
      subscriber->Restart(link_->number);
      subscribers_[id++] = {subscriber, spec};
      answer.made.emplace_back(std::move(spec), std::move(subscriber));
    }
  }
}

// Nobody waits for these any more. Not on the reader's turn, which must not wait to write.
void SceneSession::DropEach(uint64_t first, uint64_t count) {
  turns_.Post([this, first, count] {
    v1::SessionRequest request;
    for (uint64_t id = first; id < first + count; ++id) {
      request.mutable_unsubscribe()->set_subscription_id(id);
      Send(request);
    }
  });
}

void SceneSession::Receive(const v1::SubscriptionEnded& ended) {
  const auto subscriber = FindSubscriber(ended.subscription_id());
  if (subscriber == nullptr) return;
  {
    std::lock_guard lock(mutex_);
    subscribers_.erase(ended.subscription_id());
  }
  absl::Status reason = FromProto(ended.error());
  if (reason.ok()) reason = absl::CancelledError("the server ended the subscription");
  if (subscriber->ReceiveEnd(reason)) PostDelivery(subscriber);
}

void SceneSession::Receive(const v1::ArtifactUpdate& update) {
  const auto subscriber = FindSubscriber(update.subscription_id());
  // Updates may be under way when a subscription ends.
  if (subscriber == nullptr) return;
  // The mirror skips revisions, and may be behind. Only an update's first message names one.
  if (update.revision() > 0) Hear(update.revision());
  const auto is_due = subscriber->Receive(
      update, NowMs(), [this](Revision revision) { return HeardMs(revision).value_or(0.0); });
  if (!is_due.ok()) {
    End(is_due.status());
  } else if (*is_due) {
    PostDelivery(subscriber);
  }
}

// The request that the server could not read is the oldest one that has no answer: it answers in
// order. Acknowledgements, credits and presence that cross the end of what they are about want no
// answer. A hello that is refused is answered so too, and the server waits for another.
void SceneSession::Receive(const v1::SessionError& error) {
  const absl::Status status = FromProto(error.error());
  const std::string path = ErrorFieldPath(status);
  if (path == "subscription_id" || path.starts_with("presence")) return;
  if (path.starts_with("hello.")) return End(status);
  std::lock_guard lock(mutex_);
  Answers* oldest = nullptr;
  for (Answers* answers : {&commits_, &subscribes_, &controls_}) {
    if (answers->empty()) continue;
    if (!oldest || answers->begin()->first < oldest->begin()->first) oldest = answers;
  }
  if (!oldest) return;
  oldest->begin()->second->status = status;
  oldest->begin()->second->is_here = true;
  oldest->erase(oldest->begin());
}

void SceneSession::EndAll(const absl::Status& ended) {
  std::map<uint64_t, Followed> subscribers;
  std::shared_ptr<SessionPresence> presence;
  absl::Status reason;
  {
    std::lock_guard lock(mutex_);
    has_ended_ = true;
    if (end_reason_.ok()) end_reason_ = ended;
    reason = end_reason_;
    subscribers = std::exchange(subscribers_, {});
    commits_.clear();
    subscribes_.clear();
    controls_.clear();
    presence = presence_;
    changed_.notify_all();
  }
  mirror_.Stop();
  if (presence && presence->ReceiveEnd(reason)) {
    turns_.Post([presence] { presence->Deliver(); });
  }
  for (const auto& [id, followed] : subscribers) {
    if (followed.subscriber->ReceiveEnd(reason)) PostDelivery(followed.subscriber);
  }
}

void SceneSession::PostDelivery(std::shared_ptr<RemoteSubscriber> subscriber) {
  turns_.Post([this, subscriber = std::move(subscriber)] {
    subscriber->Deliver(
        [&](const Consumed& consumed) { SendConsumed(subscriber->id(), consumed); });
  });
}

std::shared_ptr<RemoteSubscriber> SceneSession::FindSubscriber(uint64_t id) {
  std::lock_guard lock(mutex_);
  const auto found = subscribers_.find(id);
  return found == subscribers_.end() ? nullptr : found->second.subscriber;
}

}  // namespace penumbra
