#include "client/cli/edit_script.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "client/cli/numbers.h"
#include "client/cli/object_edit.h"
#include "client/cli/option_error.h"
#include "client/cli/option_values.h"
#include "client/session/camera_follower.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

absl::Status Wrong(const char* reason, const std::string& field, const std::string& text) {
  return FieldError(absl::StatusCode::kInvalidArgument, reason, field, text);
}

absl::Status Need(size_t count, size_t found, const char* form) {
  if (found == count) return absl::OkStatus();
  return Wrong("MISSING_FIELD", "line",
               absl::StrCat("found another number of words, need: ", form));
}

std::string Text(const std::vector<std::string>& words, size_t from) {
  return absl::StrJoin(words.begin() + static_cast<std::ptrdiff_t>(std::min(from, words.size())),
                       words.end(), " ");
}

// Three numbers; or one that stands for all three, where that is allowed.
absl::StatusOr<Vec3> ReadVec3(const char* name, const std::string& text, bool one_will_do) {
  const auto numbers = ParseNumbers(name, text);
  if (!numbers.ok()) return numbers.status();
  if (one_will_do && numbers->size() == 1) return Vec3((*numbers)[0]);
  if (numbers->size() == 3) return Vec3At(*numbers, 0);
  return Wrong(
      "NUMBER_COUNT", name,
      absl::StrCat("found ", numbers->size(), " numbers, need ", one_will_do ? "1 or 3" : "3"));
}

}  // namespace

struct EditScript::Command {
  const char* name;
  absl::StatusOr<Json> (EditScript::*run)(const Words& words);
};

const char* EditScript::Help() {
  return "Lines:\n"
         "  move ID DX DY DZ       move an instance or a light, in metres\n"
         "  light ID R G B         give a light another radiance; one number stands for all three\n"
         "  remove ID              remove an instance, a light or a receiver\n"
         "  undo, redo             of the edits of this run that nobody else has changed since\n"
         "  camera EYE TARGET      tell the others what you look at; see --camera of view\n"
         "  select [ID...]         tell the others what you have selected\n"
         "  take [from-other]      be the only one who edits\n"
         "  hand-over NAME         let another one edit\n"
         "  release [keep]         let everybody edit or, with keep, whoever takes it next\n"
         "A line that begins with # is a comment. Each is answered by a JSON object on a line.\n";
}

EditScript::EditScript(RemoteEngine& engine, std::string scene_id, ScenePresence& presence,
                       Presence said)
    : engine_(engine),
      scene_id_(std::move(scene_id)),
      presence_(presence),
      said_(std::move(said)),
      history_(engine, scene_id_) {}

absl::StatusOr<EditScript::Json> EditScript::Do(std::string_view line) {
  static constexpr std::array<Command, 10> kCommands = {{{"move", &EditScript::Move},
                                                         {"light", &EditScript::Light},
                                                         {"remove", &EditScript::Remove},
                                                         {"undo", &EditScript::Undo},
                                                         {"redo", &EditScript::Redo},
                                                         {"camera", &EditScript::Camera},
                                                         {"select", &EditScript::Select},
                                                         {"take", &EditScript::Take},
                                                         {"hand-over", &EditScript::HandOver},
                                                         {"release", &EditScript::Release}}};
  const Words words = absl::StrSplit(absl::string_view(line.data(), line.size()),
                                     absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
  if (words.empty() || words[0].starts_with('#')) return Json();
  const auto command =
      std::ranges::find_if(kCommands, [&](const Command& c) { return words[0] == c.name; });
  if (command == kCommands.end()) {
    std::vector<std::string> names;
    for (const Command& known : kCommands) names.emplace_back(known.name);
    return OptionError("line", "UNKNOWN_COMMAND", {words[0]},
                       absl::StrCat(", need one of: ", absl::StrJoin(names, ", ")));
  }
  auto told = (this->*command->run)(words);
  if (!told.ok()) return told.status();
  Json json = {{"do", words[0]}};
  json.update(*told);
  return json;
}

absl::StatusOr<EditScript::Json> EditScript::Commit(absl::StatusOr<SceneDelta> delta) {
  if (!delta.ok()) return delta.status();
  const auto revision = history_.Commit(*delta);
  if (!revision.ok()) return revision.status();
  return Json{{"revision", *revision}};
}

absl::StatusOr<EditScript::Json> EditScript::Move(const Words& words) {
  if (words.size() < 2) return Need(5, words.size(), "move ID DX DY DZ");
  const auto by = ReadVec3("move", Text(words, 2), false);
  if (!by.ok()) return by.status();
  const auto scene = engine_.Snapshot(scene_id_);
  if (!scene.ok()) return scene.status();
  return Commit(MoveObject(**scene, words[1], *by));
}

absl::StatusOr<EditScript::Json> EditScript::Light(const Words& words) {
  if (words.size() < 2) return Need(5, words.size(), "light ID R G B");
  const auto rgb = ReadVec3("light", Text(words, 2), true);
  if (!rgb.ok()) return rgb.status();
  const auto scene = engine_.Snapshot(scene_id_);
  if (!scene.ok()) return scene.status();
  return Commit(SetLightStrength(**scene, words[1], *rgb));
}

absl::StatusOr<EditScript::Json> EditScript::Remove(const Words& words) {
  if (auto status = Need(2, words.size(), "remove ID"); !status.ok()) return status;
  const auto scene = engine_.Snapshot(scene_id_);
  if (!scene.ok()) return scene.status();
  return Commit(RemoveObject(**scene, words[1]));
}

absl::StatusOr<EditScript::Json> EditScript::Undo(const Words& words) {
  if (auto status = Need(1, words.size(), "undo"); !status.ok()) return status;
  const auto revision = history_.Undo();
  if (!revision.ok()) return revision.status();
  return Json{{"revision", *revision}};
}

absl::StatusOr<EditScript::Json> EditScript::Redo(const Words& words) {
  if (auto status = Need(1, words.size(), "redo"); !status.ok()) return status;
  const auto revision = history_.Redo();
  if (!revision.ok()) return revision.status();
  return Json{{"revision", *revision}};
}

absl::StatusOr<EditScript::Json> EditScript::Camera(const Words& words) {
  std::optional<penumbra::Camera> camera;
  if (auto status = SetCamera(Text(words, 1), camera); !status.ok()) {
    return WithoutFieldPrefix(status, "--");
  }
  Presence next = said_;
  next.view = View{.camera = *camera};
  if (auto status = presence_.Report(next); !status.ok()) return status;
  said_ = std::move(next);
  return Json::object();
}

absl::StatusOr<EditScript::Json> EditScript::Select(const Words& words) {
  Presence next = said_;
  next.selected_ids.assign(words.begin() + 1, words.end());
  if (auto status = presence_.Report(next); !status.ok()) return status;
  said_ = std::move(next);
  return Json::object();
}

absl::StatusOr<EditScript::Json> EditScript::Take(const Words& words) {
  const bool from_other = words.size() == 2 && words[1] == "from-other";
  if (words.size() > 1 && !from_other) return Need(1, words.size(), "take [from-other]");
  if (auto status = presence_.TakeEditing(from_other); !status.ok()) return status;
  return Json{{"editor", "you"}};
}

absl::StatusOr<EditScript::Json> EditScript::HandOver(const Words& words) {
  if (words.size() < 2) return Need(2, words.size(), "hand-over NAME");
  const auto other = FindParticipant(presence_.attendance(), Text(words, 1));
  if (!other.ok()) return other.status();
  if (auto status = presence_.HandOverEditing(other->id); !status.ok()) return status;
  return Json{{"editor", other->presence.display_name}};
}

absl::StatusOr<EditScript::Json> EditScript::Release(const Words& words) {
  const bool keep = words.size() == 2 && words[1] == "keep";
  if (words.size() > 1 && !keep) return Need(1, words.size(), "release [keep]");
  if (auto status = presence_.ReleaseEditing(keep); !status.ok()) return status;
  return Json{{"editor", keep ? "nobody" : "everybody"}};
}

}  // namespace penumbra
