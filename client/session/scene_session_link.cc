// The streams of a SceneSession, one after another.

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/session/backoff.h"
#include "client/session/call_status.h"
#include "client/session/channel_credentials.h"
#include "client/session/scene_session.h"
#include "client/session/server_connection.h"
#include "client/session/steady_clock.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/spec_convert.h"
#include "render/scene/field_error.h"
#include "render/scene/retry_delay.h"

namespace penumbra {
namespace {

constexpr uint32_t kProtocolVersion = 1;

constexpr double kFirstWaitS = 0.1;
constexpr double kLongestWaitS = 5.0;

// The server is away, or wants less of us: a session that it let go for not reading, or one too
// many. gRPC's own limits are resources as well, of which there is no more later.
bool MayPass(const absl::Status& reason) {
  if (absl::IsUnavailable(reason)) return true;
  return absl::IsResourceExhausted(reason) &&
         (RetryDelayMs(reason) || ErrorReason(reason) == "SLOW_CONSUMER");
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
  {
    std::lock_guard lock(mutex_);
    link->presence = presence_;
  }
  if (link->presence) *hello.mutable_presence() = link->presence->said();
  mirror_.DropPieces();
  if (const auto point = mirror_.pushed_point()) {
    hello.mutable_resume()->set_incarnation(incarnation_);
    hello.mutable_resume()->set_revision(point->revision);
    hello.mutable_resume()->set_content_hash(point->content_hash);
  }
  {
    std::lock_guard lock(mutex_);
    link->number = link_ ? link_->number + 1 : 1;
    if (!end_reason_.ok() || IsOutdated(*link)) link->context.TryCancel();
    link_ = link;
  }
  link->stream->Write(request);
  return link;
}

bool SceneSession::MayResume(const absl::Status& reason) const {
  std::lock_guard lock(mutex_);
  if (!is_welcome_ || !end_reason_.ok() || !MayPass(reason)) return false;
  return connection_.options().reconnect_for_s > 0 || IsOutdated(*link_);
}

// On the reader's turn. True: there is another link, and everything goes on on it. One that is
// wanted because of who is to be seen is opened at once, and not spoken of.
bool SceneSession::Reconnect(const absl::Status& lost) {
  const bool is_wanted = BeginReconnecting();
  if (!is_wanted) Tell(ConnectionEvent::Kind::kLost, lost, 0);
  const double give_up_ms = NowMs() + 1e3 * connection_.options().reconnect_for_s;
  absl::Status reason = lost;
  int attempts = 0;
  double wait = is_wanted ? 0.0 : kFirstWaitS;
  do {
    const double asked_ms = RetryDelayMs(reason).value_or(0);
    // Whoever is told to come back later than that need not wait to give up.
    if (asked_ms > 0 && NowMs() + asked_ms > give_up_ms) break;
    if (!WaitToTryAgain(std::max(Jittered(wait), JitteredAfter(1e-3 * asked_ms)))) return false;
    ++attempts;
    const auto link = OpenLink();
    const absl::Status resumed = Resume(link);
    if (resumed.ok()) {
      if (is_wanted) return true;
      Tell(ConnectionEvent::Kind::kRestored, absl::OkStatus(), attempts,
           response_.welcome().is_resumed());
      return true;
    }
    reason = resumed;
    if (!MayPass(resumed)) break;
    wait = std::clamp(2 * wait, kFirstWaitS, kLongestWaitS);
  } while (NowMs() < give_up_ms);
  {
    std::lock_guard lock(mutex_);
    if (end_reason_.ok()) end_reason_ = reason;
  }
  Tell(ConnectionEvent::Kind::kGivenUp, reason, attempts);
  return false;
}

bool SceneSession::BeginReconnecting() {
  const auto presence = link_->presence;
  bool is_wanted = false;
  {
    std::lock_guard lock(mutex_);
    is_wanted = IsOutdated(*link_);
    is_connected_ = false;
    changed_.notify_all();
  }
  // This turn to read may last long.
  if (presence && presence->Lose()) turns_.PostAtOnce([presence] { presence->Deliver(); });
  return is_wanted;
}

absl::Status SceneSession::Resume(const std::shared_ptr<Link>& link) {
  if (!ReadWelcome(link)) {
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
  Begin(*link);
  // Not on the reader's turn: the server may wait for us to read before it reads all of this.
  turns_.Post([this, link] { SendAgain(link); });
  turns_.Post([this] { mirror_.CatchUp(); });
  return absl::OkStatus();
}

// A server that accepts and says nothing is none.
bool SceneSession::ReadWelcome(const std::shared_ptr<Link>& link) {
  std::mutex mutex;
  std::condition_variable done;
  bool is_here = false;
  std::thread watch([&] {
    const std::chrono::duration<double> timeout(connection_.options().connect_timeout_s);
    std::unique_lock lock(mutex);
    if (!done.wait_for(lock, timeout, [&] { return is_here; })) link->context.TryCancel();
  });
  const bool is_welcome = link->stream->Read(&response_) && response_.has_welcome();
  // Of a stream that has ended by itself the status is wanted.
  if (!is_welcome) {
    while (link->stream->Read(&response_)) {
    }
  }
  {
    std::lock_guard lock(mutex);
    is_here = true;
  }
  done.notify_one();
  watch.join();
  return is_welcome;
}

// In the order of their ids, which is that in which they were asked for. Until it is done nobody
// else sends anything on this link.
void SceneSession::SendAgain(const std::shared_ptr<Link>& link) {
  std::lock_guard writing(write_mutex_);
  ResumePresence(*link);
  std::map<uint64_t, v1::SessionRequest> requests;
  v1::SessionRequest report;
  report.mutable_view_report();
  {
    std::lock_guard lock(mutex_);
    if (link_ != link) return;  // there is another one by now
    for (const auto& [id, followed] : subscribers_) {
      v1::Subscribe& subscribe = *requests[id].mutable_subscribe();
      subscribe.set_subscription_id(id);
      *subscribe.mutable_spec() = ToProto(followed.spec);
      subscribe.set_initial_credit(kInitialCredit);
      followed.subscriber->Restart(link->number);
    }
    for (const auto& [id, answer] : subscribes_) {
      if (answer->request.has_subscribe_each()) requests[id] = answer->request;
      answer->link = link->number;
    }
    for (const Answers* answers : {&commits_, &controls_}) {
      for (const auto& [id, answer] : *answers) {
        requests[id] = answer->request;
        answer->link = link->number;
      }
    }
    if (view_) *report.mutable_view_report()->mutable_camera() = ToProto(*view_);
  }
  for (const auto& [id, request] : requests) {
    link->stream->Write(request, grpc::WriteOptions().set_buffer_hint());
  }
  link->stream->Write(report);
  write_link_ = link;
  std::lock_guard lock(mutex_);
  is_connected_ = link_ == link;
  changed_.notify_all();
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
