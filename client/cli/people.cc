#include "client/cli/people.h"

#include <pwd.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/cli/json_number.h"
#include "client/cli/open_engine.h"
#include "client/cli/option_error.h"
#include "client/cli/status_table.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kNameColumns = 24;

// The login name, as `whoami` and its like find it: in a container nobody may have set USER.
std::string DefaultName() {
  for (const char* variable : {"USER", "LOGNAME"}) {
    const char* const user = std::getenv(variable);
    if (user != nullptr && *user != '\0') return user;
  }
  std::array<char, 4'096> text;
  passwd entry{};
  passwd* found = nullptr;
  const bool is_read = ::getpwuid_r(::getuid(), &entry, text.data(), text.size(), &found) == 0;
  const bool has_name = is_read && found != nullptr && *found->pw_name != '\0';
  return has_name ? found->pw_name : "somebody";
}

// One of some that are told apart on dark and bright ground, always the same for a name.
uint32_t ColourOf(const std::string& name) {
  static constexpr std::array<uint32_t, 8> kColours = {0xe0533d, 0xe69f00, 0x8db600, 0x009e73,
                                                       0x3ab5d9, 0x4b74e0, 0x9b62d4, 0xd95f9e};
  uint32_t hash = 2'166'136'261u;  // FNV-1a
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 16'777'619u;
  return kColours[hash % kColours.size()];
}

std::string HexColour(uint32_t rgb) { return absl::StrFormat("#%06x", rgb); }

std::string Swatch(uint32_t rgb, bool has_colours) {
  if (!has_colours) return HexColour(rgb);
  return absl::StrFormat("\x1b[48;2;%d;%d;%dm  \x1b[0m", rgb >> 16, rgb >> 8 & 0xff, rgb & 0xff);
}

std::string CameraText(const std::optional<View>& view) {
  if (!view) return "no camera";
  const auto text = [](Vec3 v) { return absl::StrFormat("%g %g %g", v.x, v.y, v.z); };
  return absl::StrCat("at ", text(view->camera.eye), " towards ", text(view->camera.target));
}

Json ToJson(Vec3 v) { return {JsonNumber(v.x), JsonNumber(v.y), JsonNumber(v.z)}; }

Json CameraJson(const std::optional<View>& view) {
  if (!view) return nullptr;
  return {{"eye", ToJson(view->camera.eye)},
          {"target", ToJson(view->camera.target)},
          {"up", ToJson(view->camera.up)},
          {"fov_y_deg", JsonNumber(view->camera.fov_y_deg)},
          {"aspect", JsonNumber(static_cast<float>(view->aspect))}};
}

std::string Row(const Participant& other, const Attendance& attendance, bool has_colours) {
  const Presence& presence = other.presence;
  const bool edits = attendance.single_editor && other.id == attendance.editor_id;
  return absl::StrCat(Swatch(presence.colour_rgb, has_colours), " ",
                      CellText(presence.display_name, kNameColumns), " ",
                      edits ? "edits " : "      ", CameraText(presence.view),
                      presence.selected_ids.empty() ? "" : ", selected ",
                      absl::StrJoin(presence.selected_ids, ", "), "\n");
}

}  // namespace

std::string ShownName(const std::string& name) {
  const std::string cell = CellText(name, kNameColumns);
  return std::string(absl::StripTrailingAsciiWhitespace(cell));
}

Presence PresenceOf(const PersonChoice& person) {
  const std::string name = person.name.value_or(DefaultName());
  return {.display_name = name, .colour_rgb = person.colour_rgb.value_or(ColourOf(name))};
}

absl::StatusOr<std::unique_ptr<ScenePresence>> EnterScene(RemoteEngine& engine,
                                                          const std::string& scene_id,
                                                          const PersonChoice& person,
                                                          PresenceCallback changed) {
  auto entered = engine.Enter(scene_id, PresenceOf(person), std::move(changed));
  if (entered.ok()) return entered;
  if (ErrorFieldPath(entered.status()) == "presence.display_name") {
    return OfOption("--name", entered.status());
  }
  if (absl::IsNotFound(entered.status())) return UnknownScene(engine, scene_id);
  return entered;
}

absl::StatusOr<EditingTurn> EditingTurn::Take(ScenePresence& presence, const PersonChoice& person) {
  if (!person.takes_editing && !person.takes_from_other) return EditingTurn(nullptr, false);
  const bool was_single = presence.attendance().single_editor;
  if (auto status = presence.TakeEditing(person.takes_from_other); !status.ok()) {
    return WithTakeHint(status);
  }
  return EditingTurn(&presence, was_single);
}

absl::StatusOr<PersonInScene> EnterToEdit(RemoteEngine& engine, const std::string& scene_id,
                                          const PersonChoice& person, PresenceCallback changed) {
  auto presence = EnterScene(engine, scene_id, person, std::move(changed));
  if (!presence.ok()) return presence.status();
  auto turn = EditingTurn::Take(**presence, person);
  if (!turn.ok()) return turn.status();
  return PersonInScene{*std::move(presence), *std::move(turn)};
}

EditingTurn::EditingTurn(EditingTurn&& other) noexcept
    : presence_(std::exchange(other.presence_, nullptr)),
      keeps_single_editor_(other.keeps_single_editor_) {}

EditingTurn::~EditingTurn() {
  // Whoever has taken it meanwhile keeps it.
  if (presence_) presence_->ReleaseEditing(keeps_single_editor_).IgnoreError();
}

absl::Status WithTakeHint(const absl::Status& error) {
  const std::string reason = ErrorReason(error);
  const char* hint = reason == "EDITOR_PRESENT" ? " (--from-other)"
                     : reason == "NOT_EDITOR"   ? " (--take, or --take --from-other)"
                                                : nullptr;
  if (!hint) return error;
  const std::string path = ErrorFieldPath(error);
  std::string text(error.message());
  if (text.starts_with(path + ": ")) text.erase(0, path.size() + 2);
  return FieldError(error.code(), reason, path, text + hint);
}

std::string WhoTable(const std::string& scene_id, const Attendance& attendance, bool has_colours) {
  const std::string editor = EditorName(attendance);
  std::string table = absl::StrCat(
      scene_id, ": ", attendance.others.size(), " besides you, ",
      attendance.single_editor ? absl::StrCat("one edits at a time: ", ShownName(editor))
                               : "everybody may edit",
      attendance.is_current ? "" : " (the connection is lost; this is how it was)", "\n");
  for (const Participant& other : attendance.others) {
    absl::StrAppend(&table, Row(other, attendance, has_colours));
  }
  return table;
}

Json WhoJson(const std::string& scene_id, const Attendance& attendance) {
  Json participants = Json::array();
  for (const Participant& other : attendance.others) {
    const Presence& presence = other.presence;
    participants.push_back(
        {{"id", other.id},
         {"name", presence.display_name},
         {"colour", HexColour(presence.colour_rgb)},
         {"camera", CameraJson(presence.view)},
         {"selected", presence.selected_ids},
         {"may_edit", !attendance.single_editor || other.id == attendance.editor_id}});
  }
  Json editor = nullptr;
  if (!attendance.editor_id.empty()) {
    editor = {{"id", attendance.editor_id}, {"name", EditorName(attendance)}};
  }
  return {{"scene", scene_id},
          {"you", attendance.own_id},
          {"single_editor", attendance.single_editor},
          {"editor", std::move(editor)},
          {"is_current", attendance.is_current},
          {"participants", std::move(participants)}};
}

}  // namespace penumbra
