#include "client/session/presence.h"

#include <algorithm>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "client/session/utf8.h"
#include "render/scene/field_error.h"
#include "render/scene/scene.h"

namespace penumbra {
namespace {

absl::Status Wrong(const char* reason, const char* field, const std::string& text) {
  return FieldError(absl::StatusCode::kInvalidArgument, reason, field, text);
}

absl::Status CheckName(const std::string& name, uint32_t max_bytes) {
  if (name.size() > max_bytes) {
    return Wrong("LENGTH", "presence.display_name",
                 absl::StrCat("found ", name.size(), " bytes, need at most ", max_bytes));
  }
  if (IsUtf8(name)) return absl::OkStatus();
  return Wrong("MALFORMED", "presence.display_name", "found bytes that are no text, need UTF-8");
}

absl::Status CheckSelection(const std::vector<std::string>& ids, uint32_t max_count) {
  if (ids.size() > max_count) {
    return Wrong("LENGTH", "presence.selected_ids",
                 absl::StrCat("found ", ids.size(), " ids, need at most ", max_count));
  }
  for (size_t i = 0; i < ids.size(); ++i) {
    auto status = CheckId(ids[i], absl::StrCat("presence.selected_ids[", i, "]"));
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

bool IsSame(const std::optional<View>& a, const std::optional<View>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return a->camera == b->camera && a->aspect == b->aspect;
}

}  // namespace

bool operator==(const Presence& a, const Presence& b) {
  return a.display_name == b.display_name && a.colour_rgb == b.colour_rgb &&
         IsSame(a.view, b.view) && a.selected_ids == b.selected_ids;
}

absl::Status CheckPresence(const Presence& presence, const PresenceLimits& limits) {
  absl::Status status = CheckName(presence.display_name, limits.max_display_name_bytes);
  if (status.ok() && presence.colour_rgb > 0xffffff) {
    status = Wrong("RANGE", "presence.colour_rgb",
                   absl::StrCat("found ", presence.colour_rgb, ", need at most 0xffffff"));
  }
  if (status.ok()) status = CheckSelection(presence.selected_ids, limits.max_selected_ids);
  if (!status.ok() || !presence.view) return status;
  return WithFieldPrefix(CheckView(*presence.view), "presence.");
}

const Participant* Attendance::Find(const std::string& id) const {
  const auto found = std::ranges::find(others, id, &Participant::id);
  return found == others.end() ? nullptr : &*found;
}

std::string EditorName(const Attendance& attendance) {
  if (!attendance.single_editor) return "everybody";
  if (attendance.editor_id.empty()) return "nobody";
  if (attendance.edits_self()) return "you";
  const Participant* editor = attendance.Find(attendance.editor_id);
  const bool is_named = editor != nullptr && !editor->presence.display_name.empty();
  return is_named ? editor->presence.display_name : attendance.editor_id;
}

absl::Status WithNames(const absl::Status& error, const Attendance& attendance) {
  const std::string path = ErrorFieldPath(error);
  std::string text = std::string(error.message());
  if (error.ok() || !text.starts_with(absl::StrCat(path, ": "))) return error;
  text.erase(0, path.size() + 2);
  int count = 0;
  for (const Participant& other : attendance.others) {
    const std::string& name = other.presence.display_name;
    if (name.empty() || other.id.empty()) continue;
    const std::string named = absl::StrCat(name, " (", other.id, ")");
    if (absl::StrContains(text, named)) return error;  // the server has put it there
    count += absl::StrReplaceAll({{other.id, named}}, &text);
    if (count > 0) break;
  }
  if (count == 0) return error;
  return FieldError(error.code(), ErrorReason(error), path, text);
}

}  // namespace penumbra
