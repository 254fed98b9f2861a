// penumbra edit: edits of a server's scene by somebody whom the others there see.
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/cli/edit_script.h"
#include "client/cli/line_reader.h"
#include "client/cli/open_engine.h"
#include "client/cli/people.h"
#include "client/cli/run_command.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

// Answers each line, and counts those that failed.
class Answers {
 public:
  Answers(EditScript& script, const Console& console) : script_(script), console_(console) {}

  // Whether it did what it says.
  bool Do(const std::string& line) {
    ++number_;
    const auto done = script_.Do(line);
    if (done.ok() && done->is_null()) return true;
    Json json = {{"line", number_}};
    if (done.ok()) {
      json.update(*done);
    } else {
      const absl::Status error = WithTakeHint(done.status());
      json["text"] = line;
      json["error"] = std::string(error.message());
      json["reason"] = ErrorReason(error);
      if (++failures_ == 1) first_ = error;
    }
    console_.out << json.dump(-1, ' ', false, Json::error_handler_t::replace) << std::endl;
    return done.ok();
  }

  absl::Status Result() const {
    if (failures_ < 2) return first_;
    return absl::Status(
        first_.code(), absl::StrCat(failures_, " of ", number_, " lines failed, the first because ",
                                    first_.message()));
  }

 private:
  EditScript& script_;
  const Console& console_;
  int number_ = 0;
  int failures_ = 0;
  absl::Status first_;
};

// Whoever may not edit, or no longer, is to know before the next line is refused.
PresenceCallback TellsWhoEditsNow(const Console& console) {
  return [&console](const PresenceChange& change) {
    const Attendance& now = change.now;
    if (!now.is_current || !now.single_editor || !change.editing_has_changed) return;
    if (now.edits_self() || now.editor_id.empty()) return;
    console.Note(absl::StrCat(ShownName(EditorName(now)), " edits now, and you do not"));
  };
}

}  // namespace

absl::Status Run(const EditCommand& command, const Console& console, std::stop_token stop) {
  std::unique_ptr<LineReader> reader;
  if (command.lines.empty()) {
    auto opened = LineReader::Open(command.script);
    if (!opened.ok()) return opened.status();
    reader = *std::move(opened);
  }
  const auto engine = ConnectTo(command.engine);
  if (!engine.ok()) return engine.status();
  const auto me =
      EnterToEdit(**engine, command.scene_id, command.person, TellsWhoEditsNow(console));
  if (!me.ok()) return me.status();
  EditScript script(**engine, command.scene_id, *me->presence, PresenceOf(command.person));
  Answers answers(script, console);
  if (!reader) {
    for (const std::string& line : command.lines) {
      if (!answers.Do(line) && !command.keeps_going) break;
    }
    return answers.Result();
  }
  // Whoever types sees what went wrong, and goes on.
  const bool keeps_going = command.keeps_going || reader->is_terminal();
  while (const auto line = reader->Next(stop)) {
    if (!answers.Do(*line) && !keeps_going) break;
  }
  return answers.Result();
}

}  // namespace penumbra
