// The user among the people of a server's scene.
//
//   auto me = EnterToEdit(engine, "studio", command.person);
//   me->presence->Report(…);
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "absl/status/statusor.h"
#include "client/cli/people_commands.h"
#include "client/session/remote_engine.h"
#include "client/session/scene_presence.h"

namespace penumbra {

// By the choice, without a camera or a selection.
Presence PresenceOf(const PersonChoice& person);

// Errors  those of RemoteEngine::Enter, of a name as "--name"; of a scene that the server has not,
//         "--scene" with those that it has
absl::StatusOr<std::unique_ptr<ScenePresence>> EnterScene(RemoteEngine& engine,
                                                          const std::string& scene_id,
                                                          const PersonChoice& person,
                                                          PresenceCallback changed);

// Only the user edits, for as long as this object lives; then it is as before.
class EditingTurn {
 public:
  // Nothing, where the choice does not ask for it.
  //
  // Errors  those of ScenePresence::TakeEditing
  static absl::StatusOr<EditingTurn> Take(ScenePresence& presence, const PersonChoice& person);

  EditingTurn(EditingTurn&& other) noexcept;
  EditingTurn& operator=(EditingTurn&&) = delete;
  ~EditingTurn();

 private:
  EditingTurn(ScenePresence* presence, bool keeps_single_editor)
      : presence_(presence), keeps_single_editor_(keeps_single_editor) {}

  ScenePresence* presence_;  // null: there is nothing to give back
  bool keeps_single_editor_;
};

struct PersonInScene {
  std::unique_ptr<ScenePresence> presence;
  EditingTurn turn;  // ends first
};

// Errors  those of EnterScene and EditingTurn::Take
absl::StatusOr<PersonInScene> EnterToEdit(RemoteEngine& engine, const std::string& scene_id,
                                          const PersonChoice& person,
                                          PresenceCallback changed = nullptr);

// An error that only one may edit, with the options that help.
absl::Status WithTakeHint(const absl::Status& error);

// What is known of everybody, as a table for people; `has_colours`: on a terminal that shows them.
std::string WhoTable(const std::string& scene_id, const Attendance& attendance, bool has_colours);

// The same for programs.
nlohmann::ordered_json WhoJson(const std::string& scene_id, const Attendance& attendance);

// A name as it may be shown on a terminal.
std::string ShownName(const std::string& name);

}  // namespace penumbra
