// The streams of a SceneSession, one after another.

#include <algorithm>
#include <chrono>
#include <random>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/session/call_status.h"
#include "client/session/channel_credentials.h"
#include "client/session/scene_session.h"
#include "client/session/server_connection.h"
#include "client/session/steady_clock.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/spec_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

constexpr uint32_t kProtocolVersion = 1;

constexpr double kFirstWaitS = 0.1;
constexpr double kLongestWaitS = 5.0;

// Between half of it and all of it, so that those who lost a server together do not come back
// together.
double Jittered(double seconds) {
  static thread_local std::minstd_rand random(std::random_device{}());
  return seconds * std::uniform_real_distribution<double>(0.5, 1.0)(random);
}

// The server is away, or wants less of us: a session that it let go for not reading, or one too
// many.
bool MayPass(const absl::Status& reason) {
  return absl::IsUnavailable(reason) || absl::IsResourceExhausted(reason);
}

}  // namespace

std::shared_ptr<SceneSession::Link> SceneSession::OpenLink() {
  auto link = std::make_shared<Link>();
  // The hello travels with the call's headers.
  link->context.set_initial_metadata_corked(true);
  ShowToken(connection_.options().credentials, link->context);
  link->stream = connection_.stub().Session(&link->context);
  v1::SessionRequest request;
  v1::Hello& hello = *request.mutable_hello();
  hello.add_protocol_versions(kProtocolVersion);
  hello.set_scene_id(scene_id_);
  hello.set_mirror_scene(true);
  hello.set_client_name(connection_.options().client_name);
  mirror_.DropPieces();
  if (const auto point = mirror_.pushed_point()) {
    hello.mutable_resume()->set_incarnation(incarnation_);
    hello.mutable_resume()->set_revision(point->revision);
    hello.mutable_resume()->set_content_hash(point->content_hash);
  }
  // Nobody else writes before the hello.
  std::lock_guard writing(write_mutex_);
  {
    std::lock_guard lock(mutex_);
    link->number = link_ ? link_->number + 1 : 1;
    if (!end_reason_.ok()) link->context.TryCancel();
    link_ = link;
  }
  link->stream->Write(request);
  write_link_ = link;
  return link;
}

bool SceneSession::MayResume(const absl::Status& reason) const {
  std::lock_guard lock(mutex_);
  return is_welcome_ && end_reason_.ok() && connection_.options().reconnect_for_s > 0 &&
         MayPass(reason);
}

// On the reader's turn. True: there is another link, and everything goes on on it.
bool SceneSession::Reconnect(const absl::Status& lost) {
  {
    std::lock_guard lock(mutex_);
    is_connected_ = false;
  }
  Tell(ConnectionEvent::Kind::kLost, lost, 0);
  const double give_up_ms = NowMs() + 1e3 * connection_.options().reconnect_for_s;
  absl::Status reason = lost;
  int attempts = 0;
  for (double wait = kFirstWaitS; NowMs() < give_up_ms; wait = std::min(2 * wait, kLongestWaitS)) {
    if (!WaitToTryAgain(Jittered(wait))) return false;
    ++attempts;
    const auto link = OpenLink();
    const absl::Status resumed = Resume(link);
    if (resumed.ok()) {
      Tell(ConnectionEvent::Kind::kRestored, absl::OkStatus(), attempts,
           response_.welcome().is_resumed());
      return true;
    }
    reason = resumed;
    if (!MayPass(resumed)) break;
  }
  {
    std::lock_guard lock(mutex_);
    if (end_reason_.ok()) end_reason_ = reason;
  }
  Tell(ConnectionEvent::Kind::kGivenUp, reason, attempts);
  return false;
}

absl::Status SceneSession::Resume(const std::shared_ptr<Link>& link) {
  if (!link->stream->Read(&response_) || !response_.has_welcome()) {
    link->context.TryCancel();
    return WithoutFieldPrefix(StatusOfEndedSession(address_, link->stream->Finish()), "hello.");
  }
  if (response_.welcome().incarnation() != incarnation_) {
    link->context.TryCancel();
    link->stream->Finish();
    return FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "scene_id",
                      absl::StrCat("found '", scene_id_,
                                   "', which is another scene by now, need "
                                   "the one that was opened"));
  }
  SendAgain(*link);
  std::lock_guard lock(mutex_);
  is_connected_ = true;
  changed_.notify_all();
  return absl::OkStatus();
}

// In the order of their ids, which is that in which they were asked for.
void SceneSession::SendAgain(Link& link) {
  std::map<uint64_t, v1::SessionRequest> requests;
  std::vector<std::shared_ptr<RemoteSubscriber>> subscribers;
  std::optional<View> view;
  {
    std::lock_guard lock(mutex_);
    for (const auto& [id, followed] : subscribers_) {
      v1::Subscribe& subscribe = *requests[id].mutable_subscribe();
      subscribe.set_subscription_id(id);
      *subscribe.mutable_spec() = ToProto(followed.spec);
      subscribe.set_initial_credit(kInitialCredit);
      subscribers.push_back(followed.subscriber);
    }
    for (const auto& [id, answer] : subscribes_) {
      if (answer->request.has_subscribe_each()) requests[id] = answer->request;
    }
    for (const auto& [id, answer] : commits_) requests[id] = answer->request;
    view = view_;
  }
  for (const auto& subscriber : subscribers) subscriber->Restart(link.number);
  for (const auto& [id, request] : requests) Send(request, /*more_follows=*/true, link.number);
  v1::SessionRequest report;
  report.mutable_view_report();
  if (view) *report.mutable_view_report()->mutable_camera() = ToProto(*view);
  Send(report, /*more_follows=*/false, link.number);
}

// False: the session is to end.
bool SceneSession::WaitToTryAgain(double seconds) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::duration<double>(seconds),
                    [this] { return !end_reason_.ok(); });
  return end_reason_.ok();
}

void SceneSession::Tell(ConnectionEvent::Kind kind, const absl::Status& reason, int attempts,
                        bool missed_nothing) const {
  if (!connection_.options().on_connection) return;
  connection_.options().on_connection({.kind = kind,
                                       .scene_id = scene_id_,
                                       .reason = reason,
                                       .attempts = attempts,
                                       .missed_nothing = missed_nothing});
}

}  // namespace penumbra
