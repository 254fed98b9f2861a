// What a session does with each request. Runs on one thread at a time.

#include <optional>
#include <span>
#include <string>
#include <utility>

#include "penumbra/v1/session.pb.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "proto/convert/spec_convert.h"
#include "proto/convert/status_convert.h"
#include "render/scene/field_error.h"
#include "render/scene/retry_delay.h"
#include "render/scene/scene.h"
#include "server/scene_store/commit_admission.h"
#include "server/session/bounded_parse.h"
#include "server/session/session.h"

namespace penumbra {
namespace {

absl::Status UnknownSubscription(uint64_t id) {
  return FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "subscription_id",
                    "found " + std::to_string(id) + ", need a subscription of this session");
}

// By the table of roles (rpc_roles.h). A request without a kind is none that could be refused.
absl::Status MaySend(const Caller& caller, const v1::SessionRequest& request) {
  const int kind = request.request_case();
  if (kind == v1::SessionRequest::REQUEST_NOT_SET) return absl::OkStatus();
  const auto* field = v1::SessionRequest::descriptor()->FindFieldByNumber(kind);
  return caller.Authorize("Session." + field->name());
}

absl::Status Failed(const char* reason, const char* field, const std::string& text) {
  return FieldError(absl::StatusCode::kFailedPrecondition, reason, field, text);
}

ContentHash FingerprintOf(const v1::SceneDelta& delta) {
  const std::string bytes = delta.SerializeAsString();
  return Sha256(std::as_bytes(std::span(bytes)));
}

}  // namespace

void Session::OnRequest(const grpc::ByteBuffer& bytes) {
  if (is_ending()) return;
  v1::SessionRequest request;
  absl::Status status = ParseBounded(bytes, services_.limits, request);
  if (status.ok()) status = Dispatch(request);
  if (status.ok()) return;
  record_->Refuse("request", status);
  v1::SessionResponse response;
  *response.mutable_session_error()->mutable_error() = ToProto(status);
  Push(std::move(response));
}

absl::Status Session::Dispatch(const v1::SessionRequest& request) {
  if (request.request_case() == v1::SessionRequest::kHello) return OnHello(request.hello());
  if (scene_id_.empty()) {
    return Failed("HELLO_REQUIRED", "request", "found another request, need a hello first");
  }
  const absl::Status allowed = MaySend(caller_, request);
  if (!allowed.ok() && !request.has_commit()) return allowed;
  switch (request.request_case()) {
    case v1::SessionRequest::kCommit:
      OnCommit(request.commit(), allowed);
      return absl::OkStatus();
    case v1::SessionRequest::kSubscribe:
      OnSubscribe(request.subscribe());
      return absl::OkStatus();
    case v1::SessionRequest::kSubscribeEach:
      OnSubscribeEach(request.subscribe_each());
      return absl::OkStatus();
    case v1::SessionRequest::kUnsubscribe:
      return OnUnsubscribe(request.unsubscribe());
    case v1::SessionRequest::kCredit:
      return OnCredit(request.credit());
    case v1::SessionRequest::kAcknowledgement:
      return OnAcknowledgement(request.acknowledgement());
    case v1::SessionRequest::kViewReport:
      return OnViewReport(request.view_report());
    case v1::SessionRequest::kPresence:
      return OnPresence(request.presence());
    case v1::SessionRequest::kEditControl:
      OnEditControl(request.edit_control());
      return absl::OkStatus();
    case v1::SessionRequest::kHello:
    case v1::SessionRequest::REQUEST_NOT_SET:
      break;
  }
  return FieldError(absl::StatusCode::kInvalidArgument, "MISSING_FIELD", "request",
                    "found none that this server knows, need one");
}

void Session::Apply(const v1::Commit& commit, CommitCallback done) {
  const std::string& key = commit.idempotency_key();
  ContentHash fingerprint;
  if (!key.empty()) {
    // Before the delta is looked into: what it names may be gone since it was first applied.
    fingerprint = FingerprintOf(commit.delta());
    const auto first = services_.scenes.FirstAnswer(scene_id_, key, fingerprint);
    if (!first.ok()) return done(first.status());
    if (*first) return done(**first);
  }
  if (auto status = room_->CheckMayEdit(participant_id_); !status.ok()) return done(status);
  const BlobsInScope blobs(services_.blobs, services_.blob_access, caller_.identity());
  auto delta = FromProto(commit.delta(), blobs);
  if (!delta.ok()) return done(delta.status());
  services_.scenes.Commit(scene_id_,
                          {.delta = *std::move(delta),
                           .idempotency_key = key,
                           .fingerprint = fingerprint,
                           .author_name = client_name_,
                           .principal = caller_.identity().name,
                           .bytes = commit.delta().ByteSizeLong()},
                          weak_from_this(), std::move(done));
}

void Session::OnCommit(const v1::Commit& commit, const absl::Status& allowed) {
  const auto reply = std::make_shared<Reply>(Reply{.is_ready = false});
  reply->response.mutable_commit_result()->set_commit_id(commit.commit_id());
  bool has_unanswered = false;
  {
    std::lock_guard lock(mutex_);
    if (end_ || closed_) return;
    has_unanswered = !replies_.empty();
    replies_.push_back(reply);
  }
  if (!allowed.ok()) return AnswerCommit(*reply, allowed);
  const auto admitted =
      services_.processor.AdmitCommit(caller_.identity().name, this, has_unanswered);
  // What is in already, or on its way, is answered: a refusal says that nothing has changed.
  if (!admitted.ok() && !services_.scenes.HasCommit(scene_id_, commit.idempotency_key())) {
    return AnswerCommit(*reply, admitted);
  }
  Apply(commit, [weak = weak_from_this(), reply](const absl::StatusOr<CommitOutcome>& outcome) {
    if (const auto session = weak.lock()) session->AnswerCommit(*reply, outcome);
  });
}

void Session::AnswerCommit(Reply& reply, const absl::StatusOr<CommitOutcome>& outcome) {
  v1::CommitResult& result = *reply.response.mutable_commit_result();
  if (outcome.ok()) {
    result.set_revision(outcome->revision);
    result.set_content_hash(ToProto(outcome->content_hash));
    record_->CountCommit();
  } else {
    record_->Refuse("commit", outcome.status());
    *result.mutable_error() = ToProto(outcome.status());
    if (const auto scene = services_.scenes.Snapshot(scene_id_); scene.ok()) {
      result.set_revision((*scene)->revision());
      result.set_content_hash(ToProto((*scene)->content_hash()));
    }
  }
  {
    std::lock_guard lock(mutex_);
    if (outcome.ok()) {
      reply.scene = outcome->scene;
      reply.revision = outcome->revision;
    }
    reply.is_ready = true;
    if (RetryDelayMs(outcome.status())) HurryReply(reply);
  }
  wake_();
}

void Session::OnSubscribe(const v1::Subscribe& subscribe) {
  const auto reply = std::make_shared<Reply>();
  v1::SubscribeResult& result = *reply->response.mutable_subscribe_result();
  result.set_subscription_id(subscribe.subscription_id());
  auto feed = MakeFeed(subscribe);
  if (!feed.ok()) {
    record_->Refuse("subscribe", feed.status());
    *result.mutable_error() = ToProto(feed.status());
  }
  {
    // The feed and the reply at once: no update may go out before the reply.
    std::lock_guard lock(mutex_);
    replies_.push_back(reply);
    ++unsent_subscribe_results_;
    if (feed.ok()) {
      feeds_[subscribe.subscription_id()] = *std::move(feed);
      ++services_.counters.open_subscriptions;
      record_->CountSubscriptions(1);
    }
  }
  wake_();
}

absl::StatusOr<std::unique_ptr<SubscriptionFeed>> Session::MakeFeed(
    const v1::Subscribe& subscribe) {
  const uint64_t id = subscribe.subscription_id();
  {
    std::lock_guard lock(mutex_);
    if (feeds_.contains(id)) {
      return FieldError(absl::StatusCode::kAlreadyExists, "DUPLICATE_ID", "subscription_id",
                        "found " + std::to_string(id) + ", which is open, need another");
    }
    if (feeds_.size() >= services_.limits.max_subscriptions_per_session) {
      return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_SUBSCRIPTIONS",
                        "subscription_id",
                        "found " + std::to_string(feeds_.size()) + " open, need fewer");
    }
  }
  const auto spec = FromProto(subscribe.spec());
  if (!spec.ok()) return spec.status();
  return Follow(id, *spec, subscribe.initial_credit());
}

absl::StatusOr<std::unique_ptr<SubscriptionFeed>> Session::Follow(uint64_t id,
                                                                  const ArtifactSpec& spec,
                                                                  uint32_t credit) {
  const Party party{.principal = caller_.identity().name, .viewer = viewer_};
  auto stream = services_.streams.Follow(party, scene_id_, incarnation_, spec);
  if (!stream.ok()) return stream.status();
  (*stream)->AddListener(weak_from_this());
  return std::make_unique<SubscriptionFeed>(id, *std::move(stream), credit, services_.limits);
}

absl::Status Session::OnUnsubscribe(const v1::Unsubscribe& unsubscribe) {
  const uint64_t id = unsubscribe.subscription_id();
  std::unique_ptr<SubscriptionFeed> feed;
  {
    std::lock_guard lock(mutex_);
    const auto found = feeds_.find(id);
    if (found == feeds_.end()) return UnknownSubscription(id);
    feed = std::move(found->second);
    feeds_.erase(found);
  }
  v1::SessionResponse response;
  response.mutable_subscription_ended()->set_subscription_id(id);
  // First, so that whoever hears of the end finds it no longer counted.
  Release(std::move(feed));
  Push(std::move(response));
  return absl::OkStatus();
}

absl::Status Session::OnCredit(const v1::Credit& credit) {
  {
    std::lock_guard lock(mutex_);
    const auto feed = feeds_.find(credit.subscription_id());
    if (feed == feeds_.end()) return UnknownSubscription(credit.subscription_id());
    feed->second->AddCredit(credit.updates());
  }
  wake_();
  return absl::OkStatus();
}

absl::Status Session::OnViewReport(const v1::ViewReport& report) {
  std::optional<View> view;
  if (report.has_camera()) {
    auto checked = FromProto(report.camera());
    if (!checked.ok()) return WithFieldPrefix(checked.status(), "view_report.");
    view = *checked;
  }
  return services_.scenes.ReportView(scene_id_, viewer_, view);
}

absl::Status Session::OnPresence(const v1::Presence& presence) {
  if (participant_id_.empty()) {
    return Failed("NO_PRESENCE", "presence", "found none in the hello, need one there first");
  }
  if (auto status = CheckPresence(presence, services_.limits); !status.ok()) return status;
  room_->Report(participant_id_, presence);
  return absl::OkStatus();
}

void Session::OnEditControl(const v1::EditControl& control) {
  const absl::Status status =
      participant_id_.empty()
          ? Failed("NO_PRESENCE", "edit_control", "found no presence in the hello, need one there")
          : room_->Control(participant_id_, control);
  v1::SessionResponse response;
  response.mutable_edit_control_result()->set_request_id(control.request_id());
  if (!status.ok()) *response.mutable_edit_control_result()->mutable_error() = ToProto(status);
  Push(std::move(response));
}

absl::Status Session::OnAcknowledgement(const v1::Acknowledgement& acknowledgement) {
  std::lock_guard lock(mutex_);
  const auto feed = feeds_.find(acknowledgement.subscription_id());
  if (feed == feeds_.end()) return UnknownSubscription(acknowledgement.subscription_id());
  feed->second->Acknowledge(acknowledgement.update_sequence());
  return absl::OkStatus();
}

}  // namespace penumbra
