// What was asked for of commands whose user is seen in a scene by others.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/engine_choice.h"

namespace penumbra {

// Who the user is to others, and whether they are to be the only one who edits meanwhile.
struct PersonChoice {
  std::optional<std::string> name;     // absent: the login name
  std::optional<uint32_t> colour_rgb;  // absent: one of the name's own
  bool takes_editing = false;
  bool takes_from_other = false;  // even from whoever has it
};

struct WhoCommand {
  EngineChoice engine;
  std::string scene_id;
  PersonChoice person;
  bool watch = false;        // until interrupted
  double max_seconds = 0.0;  // of watching; 0: no end
  bool json = false;
};

struct EditCommand {
  EngineChoice engine;
  std::string scene_id;
  PersonChoice person;
  std::vector<std::string> lines;      // empty: those of the script
  std::filesystem::path script = "-";  // "-": standard input
  bool keeps_going = false;            // after a line that failed
};

enum class EditingAction { kTake, kHandOver, kOneEditorOn, kOneEditorOff };

struct EditControlCommand {
  EngineChoice engine;
  std::string scene_id;
  PersonChoice person;
  EditingAction action = EditingAction::kTake;
  std::string who;           // of a hand-over: a name or an id
  double max_seconds = 0.0;  // of kTake; 0: until interrupted
  bool json = false;
};

}  // namespace penumbra
