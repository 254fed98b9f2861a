#include "client/session/attendance_book.h"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "proto/convert/geometry_convert.h"

namespace penumbra {
namespace {

// A server notices within a minute that a connection is gone; a line that breaks oftener than twice
// a second is none.
constexpr size_t kFormerIds = 128;

// Four times the sessions that servers allow, and twice what one may say of themselves: a name of
// 256 bytes and 64 ids of 256.
constexpr size_t kMostParticipants = 4'096;
constexpr size_t kMostBytesOfOne = 32 << 10;
constexpr size_t kMostIdBytes = 256;

}  // namespace

v1::Presence ToProto(const Presence& presence) {
  v1::Presence proto;
  proto.set_display_name(presence.display_name);
  proto.set_colour_rgb(presence.colour_rgb);
  if (presence.view) *proto.mutable_camera() = ToProto(*presence.view);
  proto.mutable_selected_ids()->Assign(presence.selected_ids.begin(), presence.selected_ids.end());
  return proto;
}

Presence FromProto(const v1::Presence& proto) {
  Presence presence{.display_name = proto.display_name(),
                    .colour_rgb = proto.colour_rgb() & 0xffffff,
                    .view = std::nullopt,
                    .selected_ids = {proto.selected_ids().begin(), proto.selected_ids().end()}};
  if (!proto.has_camera()) return presence;
  if (const auto view = FromProto(proto.camera()); view.ok()) presence.view = *view;
  return presence;
}

bool AttendanceBook::IsGhost(const std::string& id) const {
  return std::ranges::find(former_ids_, id) != former_ids_.end();
}

void AttendanceBook::Begin(const std::string& own_id) {
  const size_t id_bytes = now_.own_id.size();
  if (id_bytes > 0 && id_bytes <= kMostIdBytes) former_ids_.push_back(now_.own_id);
  if (former_ids_.size() > kFormerIds) former_ids_.pop_front();
  now_.own_id = own_id;
}

void AttendanceBook::Lose() {
  const bool edits = std::exchange(answered_edits_self_, {}).value_or(now_.edits_self());
  has_lost_editing_ = has_lost_editing_ || edits;
  now_.is_current = false;
}

void AttendanceBook::NoteAnswer(bool edits_self) {
  answered_edits_self_ = edits_self;
  has_lost_editing_ = false;
}

absl::Status AttendanceBook::Check(const v1::PresenceUpdate& update) const {
  const auto told = static_cast<size_t>(update.participants_size());
  // Those who are told of again count twice.
  const size_t known = update.is_everything() ? 0 : now_.others.size();
  if (told + known > 2 * kMostParticipants || told > kMostParticipants) {
    return absl::DataLossError(absl::StrCat("the server tells of ", told + known,
                                            " participants, need at most ", kMostParticipants));
  }
  for (const v1::Participant& one : update.participants()) {
    const size_t bytes = one.ByteSizeLong();
    if (bytes > kMostBytesOfOne || one.participant_id().size() > kMostIdBytes) {
      return absl::DataLossError(absl::StrCat("the server tells ", bytes,
                                              " bytes of a participant, ", "need at most ",
                                              kMostBytesOfOne));
    }
  }
  return absl::OkStatus();
}

void AttendanceBook::Apply(const v1::PresenceUpdate& update) {
  std::set<std::string> kept;
  for (const v1::Participant& told : update.participants()) {
    const std::string& id = told.participant_id();
    if (IsGhost(id)) continue;
    kept.insert(id);
    const auto known = std::ranges::find(now_.others, id, &Participant::id);
    if (known == now_.others.end()) {
      now_.others.push_back({id, FromProto(told.presence())});
    } else {
      known->presence = FromProto(told.presence());
    }
  }
  const std::set<std::string> left(update.left().begin(), update.left().end());
  std::erase_if(now_.others, [&](const Participant& other) {
    return update.is_everything() ? !kept.contains(other.id) : left.contains(other.id);
  });
  now_.single_editor = update.single_editor();
  now_.editor_id = update.editor_id();
  now_.is_current = true;
  answered_edits_self_.reset();
  const bool is_taken = !now_.editor_id.empty() && !editor_is_ghost();
  if (is_taken || !now_.single_editor) has_lost_editing_ = false;
}

PresenceChange Difference(const Attendance& before, const Attendance& now) {
  PresenceChange change{.now = now};
  for (const Participant& other : now.others) {
    const Participant* known = before.Find(other.id);
    if (known == nullptr) {
      change.joined.push_back(other.id);
    } else if (!(known->presence == other.presence)) {
      change.changed.push_back(other.id);
    }
  }
  for (const Participant& other : before.others) {
    if (now.Find(other.id) == nullptr) change.left.push_back(other);
  }
  change.editing_has_changed =
      before.single_editor != now.single_editor || before.editor_id != now.editor_id;
  return change;
}

bool IsNews(const PresenceChange& change, const Attendance& before) {
  return !change.joined.empty() || !change.changed.empty() || !change.left.empty() ||
         change.editing_has_changed || !change.ended.ok() ||
         before.is_current != change.now.is_current || before.own_id != change.now.own_id;
}

}  // namespace penumbra
