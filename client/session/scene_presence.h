// The user's presence in a scene: seen by the others who are in it, and seeing them.
//
//   auto me = engine.Enter("studio", {.display_name = "Ada", .colour_rgb = 0x3366ff},
//                          [](const PresenceChange& change) {
//                            for (const Participant& other : change.now.others) Show(other);
//                            if (change.editing_has_changed) ShowEditor(EditorName(change.now));
//                          });
//   if (!me.ok()) return me.status();   // "presence.display_name: found 300 bytes, need at most …"
//   (*me)->Report({.display_name = "Ada", .colour_rgb = 0x3366ff, .view = view});
//
// Where only one is to edit:
//
//   absl::Status taken = (*me)->TakeEditing();   // "…: found Bob (3f…) editing, need nobody, or …"
//   if (taken.ok()) engine.Commit("studio", delta);
//   (*me)->HandOverEditing(change.now.others[0].id);
//
// When the connection breaks, Attendance::is_current is false until there is another one. On that
// the server knows the user by another id, others see them go and come, and whoever edited edits on
// unless somebody has taken editing meanwhile. The user is never among the others, not even as the
// one that the server has not noticed is gone.
#pragma once

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "client/session/presence.h"

namespace penumbra {

class SceneSession;
class SessionPresence;

// Any thread may use it. It may outlive its engine; what it then asks for ends with kCancelled.
class ScenePresence {
 public:
  // By RemoteEngine::Enter.
  ScenePresence(std::shared_ptr<SceneSession> session, std::shared_ptr<SessionPresence> presence,
                const PresenceLimits& limits);
  // Others see the user go. No callback runs after this; waits for one that does, unless it is the
  // caller. Editing is left to whoever takes it.
  ~ScenePresence();
  ScenePresence(const ScenePresence&) = delete;
  ScenePresence& operator=(const ScenePresence&) = delete;

  // Who the user is and what they do, in place of what was said before. Never waits: the newest is
  // sent, at most 20 a second, and after a lost connection.
  //
  // Errors  those of CheckPresence; what has ended the session
  absl::Status Report(const Presence& presence);

  // Everybody, as last heard. What TakeEditing and its like have changed is heard within 50 ms.
  Attendance attendance() const;

  // From here on only the user may edit, and others' commits are FAILED_PRECONDITION NOT_EDITOR.
  //
  // Errors  kFailedPrecondition EDITOR_PRESENT: somebody else edits, who is named, and `from_other`
  //         is false; kPermissionDenied ROLE: the user may only look; kDeadlineExceeded,
  //         kUnavailable: no answer
  absl::Status TakeEditing(bool from_other = false);
  // Errors  kNotFound UNKNOWN_ID: nobody of that id is here; kFailedPrecondition NOT_EDITOR: it is
  //         not the user's to give; as above
  absl::Status HandOverEditing(const std::string& participant_id);
  // Leaves editing to everybody or, with `keep_single_editor`, to whoever takes it next.
  //
  // Errors  kFailedPrecondition NOT_EDITOR; as above
  absl::Status ReleaseEditing(bool keep_single_editor = false);

 private:
  const std::shared_ptr<SceneSession> session_;
  const std::shared_ptr<SessionPresence> presence_;
  const PresenceLimits limits_;
};

}  // namespace penumbra
