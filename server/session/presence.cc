#include "server/session/presence.h"

#include <algorithm>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "proto/convert/geometry_convert.h"
#include "render/scene/field_error.h"
#include "render/scene/scene.h"
#include "server/random_bytes.h"

namespace penumbra {
namespace {

absl::Status Refused(const char* reason, const std::string& text) {
  return FieldError(absl::StatusCode::kFailedPrecondition, reason, "edit_control", text);
}

bool TakesFrom(const v1::TakeEditing& take, const std::string& editor) {
  return take.from_id().empty() ? take.from_other() : take.from_id() == editor;
}

std::string NeedToEdit(const std::string& editor) {
  return absl::StrCat("found ", editor, " editing, need to be the one editor");
}

absl::Status TooLong(const char* field, size_t found, size_t most) {
  return FieldError(absl::StatusCode::kInvalidArgument, "LENGTH", field,
                    absl::StrCat("found ", found, ", need at most ", most));
}

}  // namespace

std::string PresenceRoom::Join(std::weak_ptr<PresenceListener> listener, v1::Presence presence) {
  const std::string id = absl::BytesToHexString(RandomBytes(16));
  v1::Participant participant;
  participant.set_participant_id(id);
  *participant.mutable_presence() = std::move(presence);
  std::lock_guard lock(mutex_);
  members_[id] = {.participant = std::move(participant),
                  .listener = std::move(listener),
                  .version = ++version_};
  Changed();
  return id;
}

void PresenceRoom::Leave(const std::string& id) {
  std::lock_guard lock(mutex_);
  if (members_.erase(id) == 0) return;
  left_[++version_] = id;
  // Whoever is so far behind is told everything anew.
  constexpr size_t kRemembered = 1'024;
  if (left_.size() > kRemembered) {
    forgotten_ = left_.begin()->first;
    left_.erase(left_.begin());
  }
  if (editor_ == id) {
    editor_.clear();
    editor_version_ = version_;
  }
  Changed();
}

void PresenceRoom::Report(const std::string& id, v1::Presence presence) {
  std::lock_guard lock(mutex_);
  const auto member = members_.find(id);
  if (member == members_.end()) return;
  *member->second.participant.mutable_presence() = std::move(presence);
  member->second.version = ++version_;
  Changed();
}

absl::Status PresenceRoom::Control(const std::string& id, const v1::EditControl& control) {
  std::lock_guard lock(mutex_);
  const bool is_mine = editor_ == id;
  std::string next = editor_;
  bool has_one_editor = has_one_editor_;
  switch (control.action_case()) {
    case v1::EditControl::kTake:
      if (!editor_.empty() && !is_mine && !TakesFrom(control.take(), editor_)) {
        return Refused("EDITOR_PRESENT",
                       absl::StrCat("found ", EditorName(),
                                    " editing, need nobody, or from_other, or from_id of theirs"));
      }
      next = id;
      has_one_editor = true;
      break;
    case v1::EditControl::kHandOver:
      if (!is_mine) return Refused("NOT_EDITOR", NeedToEdit(EditorName()));
      if (!members_.contains(control.hand_over().participant_id())) {
        return FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID",
                          "edit_control.hand_over.participant_id",
                          "found nobody of that id, need one who is here");
      }
      next = control.hand_over().participant_id();
      break;
    case v1::EditControl::kRelease:
      if (!is_mine) return Refused("NOT_EDITOR", NeedToEdit(EditorName()));
      next.clear();
      has_one_editor = control.release().keep_single_editor();
      break;
    case v1::EditControl::ACTION_NOT_SET:
      return FieldError(absl::StatusCode::kInvalidArgument, "MISSING_FIELD", "edit_control.action",
                        "found none that this server knows, need one");
  }
  if (next == editor_ && has_one_editor == has_one_editor_) return absl::OkStatus();
  editor_ = std::move(next);
  has_one_editor_ = has_one_editor;
  editor_version_ = ++version_;
  Changed();
  return absl::OkStatus();
}

absl::Status PresenceRoom::CheckMayEdit(const std::string& id) const {
  std::lock_guard lock(mutex_);
  if (!has_one_editor_ || (!id.empty() && editor_ == id)) return absl::OkStatus();
  return FieldError(absl::StatusCode::kFailedPrecondition, "NOT_EDITOR", "commit",
                    editor_.empty() ? "found a scene of one editor, need to take editing first"
                                    : NeedToEdit(EditorName()));
}

std::string PresenceRoom::EditorName() const {
  const auto editor = members_.find(editor_);
  if (editor == members_.end()) return "nobody";
  const std::string& name = editor->second.participant.presence().display_name();
  return name.empty() ? editor_ : absl::StrCat(name, " (", editor_, ")");
}

uint64_t PresenceRoom::AddParticipants(uint64_t since, const std::string& but,
                                       v1::PresenceUpdate& update) const {
  std::vector<const Member*> changed;
  for (const auto& [member_id, member] : members_) {
    if (member_id != but && member.version > since) changed.push_back(&member);
  }
  std::sort(changed.begin(), changed.end(),
            [](const Member* a, const Member* b) { return a->version < b->version; });
  size_t bytes = 0;
  uint64_t until = since;
  for (const Member* member : changed) {
    bytes += member->participant.ByteSizeLong();
    const auto count = static_cast<size_t>(update.participants_size());
    if (count == kMostPerUpdate || (count > 0 && bytes > kMostBytesPerUpdate)) return until;
    *update.add_participants() = member->participant;
    until = member->version;
  }
  return version_;
}

bool PresenceRoom::ChangesSince(PresenceCursor& told, const std::string& id,
                                v1::PresenceUpdate& update) const {
  std::lock_guard lock(mutex_);
  const bool is_everything = told.heard == 0 || told.heard < forgotten_;
  // Whoever is listed from here on is here: those who left before are not to be told.
  if (is_everything) told = {.listed = 0, .heard = version_};
  update.set_is_everything(is_everything);
  told.listed = AddParticipants(told.listed, id, update);
  for (auto left = left_.upper_bound(told.heard); left != left_.end(); ++left) {
    update.add_left(left->second);
  }
  update.set_single_editor(has_one_editor_);
  update.set_editor_id(editor_);
  const bool is_new = is_everything || editor_version_ > told.heard ||
                      update.participants_size() > 0 || update.left_size() > 0;
  told.heard = version_;
  return is_new;
}

bool PresenceRoom::HasMore(const PresenceCursor& told) const {
  std::lock_guard lock(mutex_);
  return told.listed < version_;
}

void PresenceRoom::Changed() {
  if (std::exchange(is_telling_, true)) return;
  delay_.Post([weak = weak_from_this()] {
    if (const auto room = weak.lock()) room->TellAll();
  });
}

void PresenceRoom::TellAll() {
  std::vector<std::shared_ptr<PresenceListener>> listeners;
  {
    std::lock_guard lock(mutex_);
    is_telling_ = false;
    for (const auto& [id, member] : members_) {
      if (auto listener = member.listener.lock()) listeners.push_back(std::move(listener));
    }
  }
  for (const auto& listener : listeners) listener->OnPresenceChanged();
}

std::shared_ptr<PresenceRoom> PresenceTable::RoomOf(const std::string& incarnation) {
  std::lock_guard lock(mutex_);
  std::erase_if(rooms_, [](const auto& room) { return room.second.expired(); });
  auto& slot = rooms_[incarnation];
  auto room = slot.lock();
  if (!room) slot = room = std::make_shared<PresenceRoom>(delay_);
  return room;
}

absl::Status CheckPresence(const v1::Presence& presence, const ServerLimits& limits) {
  if (presence.display_name().size() > limits.max_display_name_bytes) {
    return TooLong("presence.display_name", presence.display_name().size(),
                   limits.max_display_name_bytes);
  }
  if (presence.colour_rgb() > 0xffffff) {
    return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", "presence.colour_rgb",
                      absl::StrCat("found ", presence.colour_rgb(), ", need at most 0xffffff"));
  }
  const auto count = static_cast<size_t>(presence.selected_ids_size());
  if (count > limits.max_selected_ids) {
    return TooLong("presence.selected_ids", count, limits.max_selected_ids);
  }
  for (size_t i = 0; i < count; ++i) {
    const std::string path = absl::StrCat("presence.selected_ids[", i, "]");
    if (auto status = CheckId(presence.selected_ids(static_cast<int>(i)), path); !status.ok()) {
      return status;
    }
  }
  if (!presence.has_camera()) return absl::OkStatus();
  return WithFieldPrefix(FromProto(presence.camera()).status(), "presence.");
}

}  // namespace penumbra
