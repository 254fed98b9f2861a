// The user's share of a SceneSession: to be seen, and to edit where only one may.

#include <chrono>
#include <utility>

#include "client/session/scene_session.h"
#include "client/session/server_connection.h"
#include "proto/convert/status_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {

std::shared_ptr<SessionPresence> SceneSession::MakePresence(const Entry& entry) {
  // What does not get through is in the next link's hello.
  return std::make_shared<SessionPresence>(entry.presence, entry.callback,
                                           [this](const v1::Presence& newest) {
                                             v1::SessionRequest request;
                                             *request.mutable_presence() = newest;
                                             Send(request);
                                           });
}

std::shared_ptr<SessionPresence> SceneSession::presence() const {
  std::lock_guard lock(mutex_);
  return presence_;
}

// Who is seen is said when a link opens: for somebody else it takes another one.
bool SceneSession::IsOutdated(const Link& link) const { return link.presence != presence_; }

absl::Status SceneSession::Enter(const Entry& entry) {
  std::lock_guard lock(mutex_);
  if (has_ended_ || !end_reason_.ok()) return end_reason_;
  if (presence_) {
    return FieldError(absl::StatusCode::kAlreadyExists, "ALREADY_PRESENT", "presence",
                      "found one of this scene, need to report to that, or to end it first");
  }
  presence_ = MakePresence(entry);
  link_->context.TryCancel();
  return absl::OkStatus();
}

void SceneSession::Leave(const std::shared_ptr<SessionPresence>& presence) {
  std::lock_guard lock(mutex_);
  if (presence_ != presence) return;
  presence_ = nullptr;
  link_->context.TryCancel();
}

absl::Status SceneSession::ControlEditing(const v1::EditControl& control) {
  v1::SessionRequest request;
  *request.mutable_edit_control() = control;
  const auto answer = std::make_shared<Answer>();
  {
    std::lock_guard lock(mutex_);
    if (has_ended_) return end_reason_;
    request.mutable_edit_control()->set_request_id(next_id_);
    answer->request = request;
    controls_[next_id_++] = answer;
  }
  SendOnce(*answer);
  return Named(Await(controls_, request.edit_control().request_id(), answer));
}

absl::Status SceneSession::Named(const absl::Status& error) const {
  const auto mine = presence();
  return mine ? WithNames(error, mine->attendance()) : error;
}

void SceneSession::Begin(Link& link) {
  if (!link.presence) return;
  link.participant_id = response_.welcome().participant_id();
  link.presence->Begin(link.participant_id);
}

// Whoever edited when the connection was lost edits on: before anything is sent again that needs
// it. Not where somebody else has taken editing meanwhile.
void SceneSession::ResumePresence(Link& link) {
  if (!link.presence) return;
  SessionPresence& mine = *link.presence;
  v1::SessionRequest request;
  *request.mutable_presence() = mine.said();  // which may be another by now than in the hello
  link.stream->Write(request, grpc::WriteOptions().set_buffer_hint());
  const std::chrono::duration<double> timeout(connection_.options().connect_timeout_s);
  {
    std::lock_guard lock(mutex_);
    if (controls_.empty() && !mine.has_lost_editing()) return;
  }
  if (!mine.AwaitListOf(link.participant_id, timeout)) return;
  {
    // What was asked for may have come to be, and its answer have got lost.
    std::lock_guard lock(mutex_);
    for (auto& [id, answer] : controls_) {
      if (!mine.HasReached(answer->request.edit_control())) continue;
      answer->is_here = true;
      mine.NoteDone(answer->request.edit_control());
    }
    std::erase_if(controls_, [](const auto& entry) { return entry.second->is_here; });
    changed_.notify_all();
  }
  const auto take = mine.EditingToRegain();
  if (!take) return;
  // Nobody waits for the answer: the next list tells.
  *request.mutable_edit_control()->mutable_take() = *take;
  link.stream->Write(request, grpc::WriteOptions().set_buffer_hint());
}

void SceneSession::Receive(const v1::EditControlResult& result) {
  std::lock_guard lock(mutex_);
  const auto found = controls_.find(result.request_id());
  if (found == controls_.end()) return;
  found->second->status = FromProto(result.error());
  found->second->is_here = true;
  if (presence_ && found->second->status.ok()) {
    presence_->NoteDone(found->second->request.edit_control());
  }
  controls_.erase(found);
}

void SceneSession::Receive(const v1::PresenceUpdate& update) {
  const auto presence = link_->presence;
  if (!presence) return;
  const auto has_news = presence->Receive(update);
  if (!has_news.ok()) return End(has_news.status());
  if (*has_news) turns_.Post([presence] { presence->Deliver(); });
}

}  // namespace penumbra
