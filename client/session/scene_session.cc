#include "client/session/scene_session.h"

#include <chrono>
#include <random>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/session/blob_transfer.h"
#include "client/session/channel_credentials.h"
#include "client/session/server_connection.h"
#include "client/session/steady_clock.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "proto/convert/spec_convert.h"
#include "proto/convert/status_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// Ids set aside for the subscriptions of one request, whose number the server finds.
constexpr uint64_t kIdsForEach = uint64_t{1} << 20;

std::string RandomKeyPrefix() {
  std::random_device random;
  return absl::StrCat(absl::Hex(random(), absl::kZeroPad8), absl::Hex(random(), absl::kZeroPad8),
                      absl::Hex(random(), absl::kZeroPad8), "-");
}

// Ends the subscription with its handle, whether or not the engine is still there.
class RemoteSubscription : public Subscription {
 public:
  RemoteSubscription(std::shared_ptr<SceneSession> session,
                     std::shared_ptr<RemoteSubscriber> subscriber)
      : session_(std::move(session)), subscriber_(std::move(subscriber)) {}
  ~RemoteSubscription() override { session_->Unsubscribe(*subscriber_); }

 private:
  const std::shared_ptr<SceneSession> session_;
  const std::shared_ptr<RemoteSubscriber> subscriber_;
};

}  // namespace

SceneSession::SceneSession(ServerConnection& connection, const std::string& scene_id,
                           const std::optional<Entry>& entry)
    : connection_(connection),
      address_(connection.options().address),
      scene_id_(scene_id),
      mirror_(scene_id, connection.blobs()),
      key_prefix_(RandomKeyPrefix()),
      presence_(entry ? MakePresence(*entry) : nullptr),
      turns_([this] { return ReadOne(); }) {}

SceneSession::~SceneSession() {
  End(absl::CancelledError("the session was closed"));
  Join();
  if (presence_) presence_->StopSending();
}

absl::StatusOr<std::shared_ptr<SceneSession>> SceneSession::Open(
    ServerConnection& connection, const std::string& scene_id, const std::optional<Entry>& entry) {
  std::shared_ptr<SceneSession> session(new SceneSession(connection, scene_id, entry));
  if (absl::Status status = session->Greet(); !status.ok()) return status;
  return session;
}

absl::Status SceneSession::Greet() {
  write_link_ = OpenLink();
  turns_.Start();

  std::unique_lock lock(mutex_);
  const std::chrono::duration<double> timeout(connection_.options().connect_timeout_s);
  changed_.wait_for(lock, timeout, [this] { return is_welcome_ || has_ended_; });
  if (is_welcome_) return absl::OkStatus();
  // Whoever names a scene to an engine knows of no hello.
  if (has_ended_) return WithoutFieldPrefix(end_reason_, "hello.");
  return absl::UnavailableError(absl::StrCat(address_, ": no session opens in time"));
}

void SceneSession::End(const absl::Status& reason) {
  std::shared_ptr<Link> link;
  {
    std::lock_guard lock(mutex_);
    if (end_reason_.ok()) end_reason_ = reason;
    link = link_;
    changed_.notify_all();
  }
  mirror_.Stop();
  if (link) link->context.TryCancel();
}

void SceneSession::Join() { turns_.Join(); }

bool SceneSession::Send(const v1::SessionRequest& request, bool more_follows,
                        std::optional<uint64_t> link) {
  std::lock_guard lock(write_mutex_);
  if (has_ended_ || (link && *link != write_link_->number)) return false;
  grpc::WriteOptions options;
  if (more_follows) options.set_buffer_hint();
  return write_link_->stream->Write(request, options);
}

void SceneSession::SendOnce(Answer& answer) {
  std::lock_guard lock(write_mutex_);
  if (has_ended_ || std::exchange(answer.link, write_link_->number) == write_link_->number) return;
  write_link_->stream->Write(answer.request);
}

void SceneSession::SendConsumed(uint64_t subscription_id, const Consumed& consumed) {
  v1::SessionRequest request;
  request.mutable_acknowledgement()->set_subscription_id(subscription_id);
  request.mutable_acknowledgement()->set_update_sequence(consumed.acknowledged_sequence);
  Send(request, /*more_follows=*/true, consumed.link);
  request.mutable_credit()->set_subscription_id(subscription_id);
  request.mutable_credit()->set_updates(consumed.updates);
  Send(request, /*more_follows=*/false, consumed.link);
}

absl::Status SceneSession::Await(Answers& answers, uint64_t id,
                                 const std::shared_ptr<Answer>& answer) {
  std::unique_lock lock(mutex_);
  const std::chrono::duration<double> timeout(connection_.options().call_timeout_s);
  // Without a connection there is no answer; how long that may last is Reconnect's to say.
  do {
    changed_.wait_for(lock, timeout, [&] { return answer->is_here || has_ended_; });
  } while (!answer->is_here && !has_ended_ && !is_connected_);
  if (answer->is_here) return answer->status;
  if (has_ended_) return end_reason_;
  // A commit's entry stays: if its answer does come, the mirror needs it.
  if (&answers != &commits_) answers.erase(id);
  return absl::DeadlineExceededError(absl::StrCat(address_, ": no answer in time"));
}

absl::StatusOr<std::shared_ptr<const Scene>> SceneSession::Snapshot() {
  {
    std::unique_lock lock(mutex_);
    const std::chrono::duration<double> timeout(connection_.options().call_timeout_s);
    changed_.wait_for(lock, timeout, [this] { return mirror_.has_content() || has_ended_; });
    if (has_ended_) return end_reason_;
    if (!mirror_.has_content()) {
      return absl::DeadlineExceededError(
          absl::StrCat(address_, ": the scene did not come in time"));
    }
  }
  auto scene = mirror_.Newest();
  std::lock_guard lock(mutex_);
  if (!scene.ok() && !end_reason_.ok()) return end_reason_;
  return scene;
}

absl::StatusOr<std::unique_ptr<Subscription>> SceneSession::Subscribe(
    const ArtifactSpec& spec, RemoteEngine::MeasuredCallback callback) {
  v1::SessionRequest request;
  *request.mutable_subscribe()->mutable_spec() = ToProto(spec);
  request.mutable_subscribe()->set_initial_credit(kInitialCredit);
  const auto answer = std::make_shared<Answer>();
  if (auto status = connection_.CheckFits(request, "spec"); !status.ok()) return status;
  std::shared_ptr<RemoteSubscriber> subscriber;
  {
    std::lock_guard lock(mutex_);
    const uint64_t id = next_id_++;
    request.mutable_subscribe()->set_subscription_id(id);
    subscriber = std::make_shared<RemoteSubscriber>(id, std::move(callback),
                                                    connection_.blobs().scene_limits(),
                                                    mirror_.pushed_revision(), NowMs());
    answer->request = request;
    subscribers_[id] = {subscriber, spec};
    subscribes_[id] = answer;
    subscriber->Restart(link_->number);
  }
  // From here on leaving ends it.
  auto subscription = std::make_unique<RemoteSubscription>(shared_from_this(), subscriber);
  SendOnce(*answer);
  if (absl::Status status = Await(subscribes_, subscriber->id(), answer); !status.ok()) {
    return status;
  }
  return subscription;
}

absl::Status SceneSession::ReportView(const std::optional<View>& view) {
  v1::SessionRequest request;
  request.mutable_view_report();
  if (view) {
    if (absl::Status status = CheckView(*view); !status.ok()) return status;
    *request.mutable_view_report()->mutable_camera() = ToProto(*view);
  }
  // OK while the session lives: what this link is not told the next one is.
  {
    std::lock_guard lock(mutex_);
    view_ = view;
    if (!is_connected_) return end_reason_;
  }
  Send(request);
  std::lock_guard lock(mutex_);
  return end_reason_;
}

absl::StatusOr<std::vector<EachSubscription>> SceneSession::SubscribeEach(
    const EachRequest& request, RemoteEngine::EachCallback callback) {
  v1::SessionRequest message;
  v1::SubscribeEach& each = *message.mutable_subscribe_each();
  *each.mutable_technique() =
      ToProto(ArtifactSpec{.params = request.params, .points = request.points});
  each.mutable_light_ids()->Assign(request.light_ids.begin(), request.light_ids.end());
  each.mutable_receiver_ids()->Assign(request.receiver_ids.begin(), request.receiver_ids.end());
  each.set_initial_credit(kInitialCredit);
  if (auto status = connection_.CheckFits(message, "subscribe_each"); !status.ok()) return status;
  const auto answer = std::make_shared<Answer>();
  answer->params = request.params;
  answer->points = request.points;
  answer->each = std::move(callback);
  answer->asked_ms = NowMs();
  {
    std::lock_guard lock(mutex_);
    each.set_first_subscription_id(next_id_);
    next_id_ += kIdsForEach;
    answer->request = message;
    subscribes_[each.first_subscription_id()] = answer;
  }
  SendOnce(*answer);
  const absl::Status status = Await(subscribes_, each.first_subscription_id(), answer);
  // From here on leaving ends those that were made.
  std::vector<EachSubscription> subscriptions;
  for (auto& [spec, subscriber] : answer->made) {
    subscriptions.push_back(
        {spec, std::make_unique<RemoteSubscription>(shared_from_this(), subscriber)});
  }
  if (!status.ok()) return status;
  return subscriptions;
}

void SceneSession::Unsubscribe(RemoteSubscriber& subscriber) {
  bool is_known = false;
  {
    std::lock_guard lock(mutex_);
    is_known = subscribers_.erase(subscriber.id()) > 0;
  }
  if (is_known && !has_ended_) {
    v1::SessionRequest request;
    request.mutable_unsubscribe()->set_subscription_id(subscriber.id());
    Send(request);
  }
  subscriber.Close();
}

}  // namespace penumbra
