// What the server has told of who is here, one connection after another.
//
//   book.Begin(welcome.participant_id());
//   book.Apply(presence_update);
//   PresenceChange change = Difference(told, book.now());
#pragma once

#include <deque>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "client/session/presence.h"
#include "penumbra/v1/session.pb.h"

namespace penumbra {

class AttendanceBook {
 public:
  // Another connection, on which the server calls us `own_id`. What is known stays until the first
  // list comes.
  void Begin(const std::string& own_id);
  // The connection is lost.
  void Lose();
  // Whether `update` is of a size that a server's can be.
  //
  // Errors  kDataLoss: more people, or more said of one of them, than a scene can hold
  absl::Status Check(const v1::PresenceUpdate& update) const;
  void Apply(const v1::PresenceUpdate& update);

  const Attendance& now() const { return now_; }

  // Whether we edited when a connection was lost, and nobody has taken it up since.
  bool has_lost_editing() const { return has_lost_editing_; }
  // The server has answered that we edit, or do no longer; the list that says so comes later.
  void NoteAnswer(bool edits_self);
  // Whether the server takes somebody for the editor who is ourselves on an earlier connection,
  // whose end it has not noticed yet.
  bool editor_is_ghost() const { return IsGhost(now_.editor_id); }

 private:
  bool IsGhost(const std::string& id) const;

  Attendance now_;
  std::deque<std::string> former_ids_;       // own, the oldest first
  std::optional<bool> answered_edits_self_;  // since the list came
  bool has_lost_editing_ = false;
};

PresenceChange Difference(const Attendance& before, const Attendance& now);
// Whether there is anything to tell in `change`, which came after `before`.
bool IsNews(const PresenceChange& change, const Attendance& before);

v1::Presence ToProto(const Presence& presence);
// A camera that is none is left out.
Presence FromProto(const v1::Presence& presence);

}  // namespace penumbra
