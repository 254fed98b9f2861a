// What a client hears in its session, and what has to be true of it.

#include <algorithm>

#include "proto/convert/geometry_convert.h"
#include "proto/convert/status_convert.h"
#include "render/scene/field_error.h"
#include "tests/fuzz/kit/require.h"
#include "tests/fuzz/targets/session_client.h"

namespace penumbra::fuzzing {
namespace {

// Those that are refused in an answer of their own.
bool HasResult(const v1::SessionRequest& request) {
  return request.has_commit() || request.has_subscribe() || request.has_subscribe_each() ||
         request.has_edit_control();
}

// Whether a hello asks for what there is.
bool MayBeWelcome(const v1::Hello& hello) {
  const auto& versions = hello.protocol_versions();
  return hello.scene_id() == "studio" &&
         std::find(versions.begin(), versions.end(), 1u) != versions.end();
}

}  // namespace

bool SessionClient::Hear(const v1::SessionResponse& response) {
  switch (response.response_case()) {
    case v1::SessionResponse::kWelcome:
      OnWelcome(response.welcome());
      return true;
    case v1::SessionResponse::kSessionError:
      OnSessionError(response.session_error());
      return true;
    case v1::SessionResponse::kCommitResult:
      OnCommitResult(response.commit_result());
      return true;
    case v1::SessionResponse::kSubscribeResult:
      OnSubscribeResult(response.subscribe_result());
      return true;
    case v1::SessionResponse::kSubscribeEachResult:
      OnSubscribeEachResult(response.subscribe_each_result());
      return true;
    case v1::SessionResponse::kEditControlResult:
      OnEditControlResult(response.edit_control_result());
      return true;
    case v1::SessionResponse::kSubscriptionEnded:
      OnSubscriptionEnded(response.subscription_ended());
      return !is_scene_gone_;
    default:
      HearNews(response);
      return false;
  }
}

void SessionClient::HearNews(const v1::SessionResponse& response) {
  switch (response.response_case()) {
    case v1::SessionResponse::kSceneUpdate:
      return OnSceneUpdate(response.scene_update());
    case v1::SessionResponse::kArtifactUpdate:
      return OnArtifactUpdate(response.artifact_update());
    case v1::SessionResponse::kUpdatesSkipped:
      return OnUpdatesSkipped(response.updates_skipped());
    case v1::SessionResponse::kPresenceUpdate:
      return OnPresenceUpdate(response.presence_update());
    default:
      Require(false, "a server says what there is to say");
  }
}

absl::Status SessionClient::Refused(const google::rpc::Status& error) {
  const absl::Status status = FromProto(error);
  RequireNamedRefusal(status);
  count_(false);
  return status;
}

void SessionClient::OnEnd(const absl::Status& end) {
  RequireNamedRefusal(end);
  Settle();
  is_over_ = true;
  if (is_scene_gone_) {
    Require(is_welcome_ && absl::IsNotFound(end), "a session ends with its scene, and says so");
    return Require(said_.empty() && followed_.empty(), "after all that it had to say");
  }
  Require(!is_welcome_ && !said_.empty() && said_.front().request.has_hello() &&
              !MayBeWelcome(said_.front().request.hello()),
          "a session ends where its hello asks for what there is not");
  // What came after that was not read.
  said_.clear();
  count_(false);
}

void SessionClient::OnWelcome(const v1::Welcome& welcome) {
  const Said said = TakeAnswered();
  const v1::Hello& hello = said.request.hello();
  Require(said.parsed.ok() && said.request.has_hello() && !is_welcome_ && MayBeWelcome(hello),
          "the first sound hello alone is welcome");
  Require(welcome.incarnation() == server_.incarnation() && welcome.protocol_version() == 1 &&
              welcome.scene().scene_id() == "studio" && welcome.scene().revision() == said.revision,
          "a welcome is to the scene that was asked for");
  Require(welcome.participant_id().empty() != hello.has_presence(), "whoever says who they are is");
  Require(!welcome.is_resumed() || (hello.mirror_scene() && hello.has_resume()),
          "nothing is resumed that was not to be");
  is_welcome_ = true;
  has_presence_ = hello.has_presence();
  mirrors_ = hello.mirror_scene();
  participant_id_ = welcome.participant_id();
  if (!welcome.is_resumed()) return;
  told_ = hello.resume().revision();
  Require(told_ < history_.hashes.size() &&
              ToProto(history_.hashes[told_]) == hello.resume().content_hash(),
          "what is resumed is what there was");
}

void SessionClient::OnSessionError(const v1::SessionError& error) {
  const Said said = TakeAnswered();
  const absl::Status status = Refused(error.error());
  if (!said.parsed.ok()) {
    return Require(ErrorReason(status) == ErrorReason(said.parsed),
                   "what cannot be read is answered with the reason");
  }
  const v1::SessionRequest& request = said.request;
  if (!is_welcome_) {
    return Require(request.has_hello() || ErrorReason(status) == "HELLO_REQUIRED",
                   "a hello comes first");
  }
  Require(!HasResult(request), "what has an answer of its own gets that");
  Require(
      !request.has_unsubscribe() || !followed_.contains(request.unsubscribe().subscription_id()),
      "what is followed can be let go");
}

void SessionClient::OnCommitResult(const v1::CommitResult& result) {
  const Said said = TakeAnswered();
  const v1::Commit& commit = said.request.commit();
  Require(is_welcome_ && said.parsed.ok() && said.request.has_commit() &&
              result.commit_id() == commit.commit_id(),
          "a commit gets one answer, with its id, in the order of sending");
  Require(result.revision() < history_.hashes.size() &&
              result.content_hash() == ToProto(history_.hashes[result.revision()]),
          "a revision is told with its hash");
  if (result.has_error()) {
    Refused(result.error()).IgnoreError();
    return Require(!said.has_grown && result.revision() == said.revision,
                   "a commit that is refused has changed nothing");
  }
  count_(true);
  const auto first = history_.answers.find(commit.idempotency_key());
  Require(said.has_grown ? result.revision() == said.revision
                         : first != history_.answers.end() && result.revision() == first->second,
          "a commit that is acknowledged has made a revision, once");
  if (!mirrors_) return;
  Require(told_ + 1 >= result.revision() && !is_continued_, "what a commit builds on comes first");
  told_ = std::max(told_, result.revision());
}

void SessionClient::Follow(uint64_t id, uint32_t credit) {
  const Followed followed{.credit = std::min(credit, server_.limits().max_credit)};
  Require(followed_.emplace(id, followed).second, "an id stands for one subscription");
  Require(followed_.size() <= server_.limits().max_subscriptions_per_session,
          "there are not too many subscriptions");
}

void SessionClient::OnSubscribeResult(const v1::SubscribeResult& result) {
  const Said said = TakeAnswered();
  const v1::Subscribe& subscribe = said.request.subscribe();
  const uint64_t id = subscribe.subscription_id();
  Require(is_welcome_ && said.parsed.ok() && said.request.has_subscribe() &&
              result.subscription_id() == id,
          "a subscribe gets one answer, with its id, in the order of sending");
  if (result.has_error()) {
    const absl::Status status = Refused(result.error());
    return Require(!followed_.contains(id) || ErrorReason(status) == "DUPLICATE_ID",
                   "an id that is taken is the first thing that is wrong");
  }
  count_(true);
  Follow(id, subscribe.initial_credit());
}

void SessionClient::OnSubscribeEachResult(const v1::SubscribeEachResult& result) {
  const Said said = TakeAnswered();
  const v1::SubscribeEach& each = said.request.subscribe_each();
  Require(is_welcome_ && said.parsed.ok() && said.request.has_subscribe_each() &&
              result.first_subscription_id() == each.first_subscription_id(),
          "a subscribe_each gets one answer, with its id, in the order of sending");
  if (result.has_error()) {
    Refused(result.error()).IgnoreError();
    return Require(result.light_ids().empty() && result.receiver_ids().empty(),
                   "all of the subscriptions are made or none is");
  }
  count_(true);
  const auto count = static_cast<uint64_t>(result.light_ids_size()) *
                     static_cast<uint64_t>(result.receiver_ids_size());
  for (uint64_t i = 0; i < count; ++i) {
    Follow(each.first_subscription_id() + i, each.initial_credit());
  }
}

void SessionClient::OnSubscriptionEnded(const v1::SubscriptionEnded& ended) {
  const uint64_t id = ended.subscription_id();
  Require(ended.has_error() == is_scene_gone_, "a subscription ends by request, or with its scene");
  if (is_scene_gone_) {
    const absl::Status reason = FromProto(ended.error());
    RequireNamedRefusal(reason);
    Require(absl::IsNotFound(reason), "a scene that is gone is not found");
  } else {
    const Said said = TakeAnswered();
    Require(said.parsed.ok() && said.request.has_unsubscribe() &&
                said.request.unsubscribe().subscription_id() == id,
            "an unsubscribe gets one answer, with its id, in the order of sending");
    count_(true);
  }
  Require(followed_.erase(id) == 1, "what ends was followed");
}

void SessionClient::OnEditControlResult(const v1::EditControlResult& result) {
  const Said said = TakeAnswered();
  const v1::EditControl& control = said.request.edit_control();
  Require(is_welcome_ && said.parsed.ok() && said.request.has_edit_control() &&
              result.request_id() == control.request_id(),
          "an edit_control gets one answer, with its id, in the order of sending");
  if (!result.has_error()) return count_(true);
  Refused(result.error()).IgnoreError();
  Require(!said.has_other_editor, "what is refused changes nothing");
}

void SessionClient::OnSceneUpdate(const v1::SceneUpdate& update) {
  Require(is_welcome_ && mirrors_, "whoever wants no mirror is told of none");
  Require(update.from_revision() == told_ && update.revision() > told_,
          "an update builds on what was told");
  Require(update.is_snapshot() == (told_ == 0 && !is_continued_), "a mirror begins with all");
  Require(update.revision() < history_.hashes.size() &&
              update.content_hash() == ToProto(history_.hashes[update.revision()]),
          "an update leads to a scene that there was");
  is_continued_ = update.is_continued();
  if (!is_continued_) told_ = update.revision();
}

void SessionClient::OnArtifactUpdate(const v1::ArtifactUpdate& update) {
  Settle();
  Require(said_.empty(), "answers come before what follows from them");
  const auto found = followed_.find(update.subscription_id());
  Require(found != followed_.end(), "updates are of what is followed");
  Followed& followed = found->second;
  if (!followed.in_update) {
    Require(followed.credit > 0, "an update takes credit");
    --followed.credit;
    Require(update.revision() > 0 && update.revision() < history_.hashes.size(),
            "an artifact is of a scene that there was");
  }
  if (update.has_error()) RequireNamedRefusal(FromProto(update.error()));
  Require(
      update.update_sequence() >= followed.sequence && update.base_sequence() <= followed.sequence,
      "an update builds on what has been sent");
  followed.in_update = !update.end_of_update();
  if (!followed.in_update) followed.sequence = update.update_sequence();
}

void SessionClient::OnUpdatesSkipped(const v1::UpdatesSkipped& skipped) {
  const auto found = followed_.find(skipped.subscription_id());
  Require(found != followed_.end() && skipped.total() > found->second.skipped,
          "of what is followed more and more is skipped");
  found->second.skipped = skipped.total();
}

void SessionClient::OnPresenceUpdate(const v1::PresenceUpdate& update) {
  Require(has_presence_, "others are told to those who are seen");
  Require(update.is_everything() != is_told_of_others_, "whoever comes is told everything, once");
  is_told_of_others_ = true;
  for (const v1::Participant& participant : update.participants()) {
    Require(participant.participant_id() != participant_id_, "nobody is told of himself");
  }
  Require(update.editor_id().empty() || update.single_editor(), "one edits where only one may");
}

}  // namespace penumbra::fuzzing
