// What a session does with each request. Runs on one thread at a time.

#include <algorithm>
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
#include "render/scene/scene.h"
#include "server/server_identity.h"
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

absl::Status MayOpen(const Caller& caller, const std::string& scene_id) {
  absl::Status status = CheckId(scene_id, "scene_id");
  if (status.ok()) status = caller.Authorize("Session.hello", scene_id);
  return status.ok() ? status : WithFieldPrefix(status, "hello.");
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
    case v1::SessionRequest::kHello:
    case v1::SessionRequest::REQUEST_NOT_SET:
      break;
  }
  return FieldError(absl::StatusCode::kInvalidArgument, "MISSING_FIELD", "request",
                    "found none that this server knows, need one");
}

absl::Status Session::OnHello(const v1::Hello& hello) {
  if (!scene_id_.empty()) {
    return Failed("HELLO_REPEATED", "hello", "found a second one, need one in a session");
  }
  const auto& versions = hello.protocol_versions();
  if (std::find(versions.begin(), versions.end(), kProtocolVersion) == versions.end()) {
    End(Failed(
        "VERSION", "hello.protocol_versions",
        "found no version that this server speaks, need " + std::to_string(kProtocolVersion)));
    return absl::OkStatus();
  }
  if (hello.client_name().size() > services_.limits.max_client_name_bytes) {
    return FieldError(absl::StatusCode::kInvalidArgument, "LENGTH", "hello.client_name",
                      "found " + std::to_string(hello.client_name().size()) +
                          " bytes, need at most " +
                          std::to_string(services_.limits.max_client_name_bytes));
  }
  if (auto status = MayOpen(caller_, hello.scene_id()); !status.ok()) {
    End(status);
    return absl::OkStatus();
  }
  const auto watched = services_.scenes.Watch(hello.scene_id(), weak_from_this());
  if (!watched.ok()) {
    End(WithFieldPrefix(watched.status(), "hello."));
    return absl::OkStatus();
  }
  scene_id_ = hello.scene_id();
  incarnation_ = watched->incarnation;
  Push(MakeWelcome(*watched->scene, kProtocolVersion));
  if (hello.mirror_scene()) {
    {
      std::lock_guard lock(mutex_);
      mirrors_scene_ = true;
    }
    // The newest: a commit may have come between.
    const auto newest = services_.scenes.Snapshot(scene_id_);
    if (newest.ok()) OnScene(*newest);
  }
  return absl::OkStatus();
}

v1::SessionResponse Session::MakeWelcome(const Scene& scene, uint32_t version) const {
  v1::SessionResponse response;
  v1::Welcome& welcome = *response.mutable_welcome();
  welcome.set_protocol_version(version);
  welcome.set_server_name(kServerName);
  *welcome.mutable_limits() = ToProto(services_.limits);
  for (auto& technique : AllTechniqueInfos()) *welcome.add_techniques() = std::move(technique);
  for (const v1::Codec codec :
       {v1::CODEC_RAW, v1::CODEC_ZSTD, v1::CODEC_ALL_VISIBLE, v1::CODEC_NONE_VISIBLE}) {
    welcome.add_codecs(codec);
  }
  *welcome.mutable_scene() = ToProto(InfoOf(scene));
  return response;
}

absl::StatusOr<CommitOutcome> Session::Apply(const v1::Commit& commit) {
  const std::string& key = commit.idempotency_key();
  ContentHash fingerprint;
  if (!key.empty()) {
    // Before the delta is looked into: what it names may be gone since it was first applied.
    fingerprint = FingerprintOf(commit.delta());
    const auto first = services_.scenes.FirstAnswer(scene_id_, key, fingerprint);
    if (!first.ok()) return first.status();
    if (*first) return **first;
  }
  const BlobsInScope blobs(services_.blobs, services_.blob_access, caller_.identity());
  const auto delta = FromProto(commit.delta(), blobs);
  if (!delta.ok()) return delta.status();
  return services_.scenes.Commit(
      scene_id_, {.delta = *delta, .idempotency_key = key, .fingerprint = fingerprint}, this);
}

void Session::OnCommit(const v1::Commit& commit, const absl::Status& allowed) {
  v1::SessionResponse response;
  v1::CommitResult& result = *response.mutable_commit_result();
  result.set_commit_id(commit.commit_id());
  const auto outcome = allowed.ok() ? Apply(commit) : absl::StatusOr<CommitOutcome>(allowed);
  std::shared_ptr<const Scene> own;
  if (outcome.ok()) {
    result.set_revision(outcome->revision);
    result.set_content_hash(ToProto(outcome->content_hash));
    own = outcome->scene;
  } else {
    *result.mutable_error() = ToProto(outcome.status());
    if (const auto scene = services_.scenes.Snapshot(scene_id_); scene.ok()) {
      result.set_revision((*scene)->revision());
      result.set_content_hash(ToProto((*scene)->content_hash()));
    }
  }
  Push(std::move(response), std::move(own));
}

void Session::OnSubscribe(const v1::Subscribe& subscribe) {
  Reply reply;
  v1::SubscribeResult& result = *reply.response.mutable_subscribe_result();
  result.set_subscription_id(subscribe.subscription_id());
  auto feed = MakeFeed(subscribe);
  if (!feed.ok()) *result.mutable_error() = ToProto(feed.status());
  {
    // The feed and the reply at once: no update may go out before the reply.
    std::lock_guard lock(mutex_);
    replies_.push_back(std::move(reply));
    if (feed.ok()) {
      feeds_[subscribe.subscription_id()] = *std::move(feed);
      ++services_.counters.open_subscriptions;
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
  auto stream = services_.streams.Follow(scene_id_, incarnation_, spec);
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

absl::Status Session::OnAcknowledgement(const v1::Acknowledgement& acknowledgement) {
  std::lock_guard lock(mutex_);
  const auto feed = feeds_.find(acknowledgement.subscription_id());
  if (feed == feeds_.end()) return UnknownSubscription(acknowledgement.subscription_id());
  feed->second->Acknowledge(acknowledgement.update_sequence());
  return absl::OkStatus();
}

}  // namespace penumbra
