// penumbra edit-control: who may edit a server's scene.
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "client/cli/open_engine.h"
#include "client/cli/option_error.h"
#include "client/cli/people.h"
#include "client/cli/run_command.h"
#include "client/session/camera_follower.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// Who is here, as the session's threads hear it.
class People {
 public:
  PresenceCallback callback() {
    return [this](const PresenceChange& change) {
      std::lock_guard lock(mutex_);
      newest_ = change;
      changed_.notify_all();
    };
  }

  // Until `is_so` of what is heard, a stop, or the time is over; 0: no end. The newest then.
  template <typename Predicate>
  PresenceChange WaitFor(Predicate is_so, double max_seconds, const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    const auto is_over = [&] { return !newest_.ended.ok() || is_so(newest_.now); };
    if (max_seconds > 0.0) {
      const std::chrono::duration<double> longest(std::min(max_seconds, 1e8));
      changed_.wait_for(lock, stop, longest, is_over);
    } else {
      changed_.wait(lock, stop, is_over);
    }
    return newest_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable_any changed_;
  PresenceChange newest_;
};

void Say(const EditControlCommand& command, const std::string& editor, bool single_editor,
         const Console& console) {
  if (command.json) {
    const nlohmann::ordered_json json = {
        {"scene", command.scene_id}, {"single_editor", single_editor}, {"editor", editor}};
    console.out << json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) << std::endl;
  } else if (!single_editor) {
    console.out << command.scene_id << ": everybody may edit" << std::endl;
  } else {
    console.out << command.scene_id << ": one edits at a time: " << ShownName(editor) << std::endl;
  }
}

// Holds editing, since whoever leaves leaves it to others.
absl::Status Hold(const EditControlCommand& command, ScenePresence& me, People& people,
                  const Console& console, const std::stop_token& stop) {
  constexpr double kHeardWithinS = 5.0;
  const PresenceChange first =
      people.WaitFor([](const Attendance& now) { return now.edits_self(); }, kHeardWithinS, stop);
  if (!first.ended.ok()) return first.ended;
  if (stop.stop_requested()) return absl::OkStatus();
  if (!first.now.edits_self()) {
    // What is heard is older than the answer, or somebody was very quick.
    return absl::DeadlineExceededError(absl::StrCat("edit_control: found no word within ",
                                                    kHeardWithinS, " s that you edit, but ",
                                                    ShownName(EditorName(first.now))));
  }
  Say(command, "you", true, console);
  const auto is_taken = [](const Attendance& now) { return now.is_current && !now.edits_self(); };
  const PresenceChange last = people.WaitFor(is_taken, command.max_seconds, stop);
  if (!last.ended.ok()) return last.ended;
  if (!is_taken(last.now)) return absl::OkStatus();
  return FieldError(
      absl::StatusCode::kAborted, "NOT_EDITOR", "edit_control",
      absl::StrCat("found that ", ShownName(EditorName(me.attendance())), " has taken editing"));
}

// As it was before it was taken: the scene is not to stay closed to everybody over something that
// did not come about.
void GiveBack(const Attendance& before, ScenePresence& me) {
  const bool had_editor = before.single_editor && !before.editor_id.empty();
  if (had_editor && me.HandOverEditing(before.editor_id).ok()) return;
  me.ReleaseEditing(before.single_editor).IgnoreError();
}

absl::Status HandOver(const EditControlCommand& command, ScenePresence& me,
                      const Console& console) {
  const Attendance before = me.attendance();
  const auto other = FindParticipant(before, command.who);
  if (!other.ok()) return OfOption("WHO", other.status());
  absl::Status status = me.TakeEditing(command.person.takes_from_other);
  if (!status.ok()) return WithTakeHint(status);
  status = me.HandOverEditing(other->id);
  if (!status.ok()) {
    GiveBack(before, me);
    return status;
  }
  Say(command, other->presence.display_name, true, console);
  return absl::OkStatus();
}

absl::Status SetOneEditor(const EditControlCommand& command, bool single_editor, ScenePresence& me,
                          const Console& console) {
  const Attendance before = me.attendance();
  const bool is_so = before.single_editor == single_editor && before.editor_id.empty();
  if (!is_so) {
    absl::Status status = me.TakeEditing(command.person.takes_from_other);
    if (!status.ok()) return WithTakeHint(status);
    status = me.ReleaseEditing(single_editor);
    if (!status.ok()) {
      GiveBack(before, me);
      return status;
    }
  }
  Say(command, single_editor ? "nobody" : "everybody", single_editor, console);
  if (single_editor && before.others.empty()) {
    console.Note("nobody else is here, and with the last one who leaves it is forgotten");
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status Run(const EditControlCommand& command, const Console& console, std::stop_token stop) {
  const auto engine = ConnectTo(command.engine);
  if (!engine.ok()) return engine.status();
  People people;
  const auto me = EnterScene(**engine, command.scene_id, command.person, people.callback());
  if (!me.ok()) return me.status();
  switch (command.action) {
    case EditingAction::kTake: {
      PersonChoice person = command.person;
      person.takes_editing = true;
      const auto turn = EditingTurn::Take(**me, person);
      if (!turn.ok()) return turn.status();
      return Hold(command, **me, people, console, stop);
    }
    case EditingAction::kHandOver:
      return HandOver(command, **me, console);
    case EditingAction::kOneEditorOn:
      return SetOneEditor(command, true, **me, console);
    case EditingAction::kOneEditorOff:
      return SetOneEditor(command, false, **me, console);
  }
  return absl::OkStatus();
}

}  // namespace penumbra
