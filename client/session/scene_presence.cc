#include "client/session/scene_presence.h"

#include <utility>

#include "client/session/scene_session.h"
#include "client/session/session_presence.h"

namespace penumbra {

ScenePresence::ScenePresence(std::shared_ptr<SceneSession> session,
                             std::shared_ptr<SessionPresence> presence,
                             const PresenceLimits& limits)
    : session_(std::move(session)), presence_(std::move(presence)), limits_(limits) {}

ScenePresence::~ScenePresence() {
  presence_->Close();
  // A report that waits for the server to read ends with its connection.
  session_->Leave(presence_);
  presence_->StopSending();
}

absl::Status ScenePresence::Report(const Presence& presence) {
  if (auto status = CheckPresence(presence, limits_); !status.ok()) return status;
  if (auto status = presence_->ended(); !status.ok()) return status;
  presence_->Report(ToProto(presence));
  return absl::OkStatus();
}

Attendance ScenePresence::attendance() const { return presence_->attendance(); }

absl::Status ScenePresence::TakeEditing(bool from_other) {
  v1::EditControl control;
  control.mutable_take()->set_from_other(from_other);
  return session_->ControlEditing(control);
}

absl::Status ScenePresence::HandOverEditing(const std::string& participant_id) {
  v1::EditControl control;
  control.mutable_hand_over()->set_participant_id(participant_id);
  return session_->ControlEditing(control);
}

absl::Status ScenePresence::ReleaseEditing(bool keep_single_editor) {
  v1::EditControl control;
  control.mutable_release()->set_keep_single_editor(keep_single_editor);
  return session_->ControlEditing(control);
}

}  // namespace penumbra
