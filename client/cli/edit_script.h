// Edits of a server's scene, one line each.
//
//   EditScript script(engine, "studio", me);
//   auto done = script.Do("move lamp 0.5 0 0");   // {"do": "move", "revision": 12}
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "client/session/edit_history.h"
#include "client/session/remote_engine.h"
#include "client/session/scene_presence.h"

namespace penumbra {

class EditScript {
 public:
  using Json = nlohmann::ordered_json;

  // What a line may be, for people.
  static const char* Help();

  // `said` is what the user has told of themselves. Engine and presence must outlive it.
  EditScript(RemoteEngine& engine, std::string scene_id, ScenePresence& presence, Presence said);

  // What a line did: "do", the command, and what is to be told of it, as the "revision" that it
  // made. Null: the line is empty, or a comment.
  //
  // Errors  kInvalidArgument UNKNOWN_COMMAND, NUMBER, NUMBER_COUNT, MISSING_FIELD: the line makes
  //         no sense; those of what it asks for
  absl::StatusOr<Json> Do(std::string_view line);

 private:
  struct Command;  // its name, and what it does
  using Words = std::vector<std::string>;

  absl::StatusOr<Json> Move(const Words& words);
  absl::StatusOr<Json> Light(const Words& words);
  absl::StatusOr<Json> Remove(const Words& words);
  absl::StatusOr<Json> Undo(const Words& words);
  absl::StatusOr<Json> Redo(const Words& words);
  absl::StatusOr<Json> Camera(const Words& words);
  absl::StatusOr<Json> Select(const Words& words);
  absl::StatusOr<Json> Take(const Words& words);
  absl::StatusOr<Json> HandOver(const Words& words);
  absl::StatusOr<Json> Release(const Words& words);
  absl::StatusOr<Json> Commit(absl::StatusOr<SceneDelta> delta);

  RemoteEngine& engine_;
  const std::string scene_id_;
  ScenePresence& presence_;
  Presence said_;
  EditHistory history_;
};

}  // namespace penumbra
