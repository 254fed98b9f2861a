// Who is in a scene with us, and what they do.
//
//   Presence me{.display_name = "Ada", .colour_rgb = 0x3366ff};
//   for (const Participant& other : attendance.others) Show(other.presence.display_name);
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "render/scene/camera.h"

namespace penumbra {

// Who somebody is and what they do.
struct Presence {
  std::string display_name;               // for people to read, in UTF-8; two may have the same
  uint32_t colour_rgb = 0;                // in which others show them, 0xRRGGBB of sRGB
  std::optional<View> view;               // what they look at; absent: not told
  std::vector<std::string> selected_ids;  // they need not exist

  friend bool operator==(const Presence&, const Presence&);
};

// What a server takes of it.
struct PresenceLimits {
  uint32_t max_display_name_bytes = 256;
  uint32_t max_selected_ids = 64;
};

// Errors  kInvalidArgument, by the field's name: "presence.display_name" LENGTH, or MALFORMED where
//         it is no UTF-8; "presence.colour_rgb" RANGE; "presence.selected_ids" LENGTH, or BAD_ID of
//         one of them; those of CheckView at "presence.camera…"
absl::Status CheckPresence(const Presence& presence, const PresenceLimits& limits = {});

struct Participant {
  std::string id;  // for the time of their connection
  Presence presence;
};

// Everybody at one moment.
struct Attendance {
  std::string own_id;               // another one on each connection
  std::vector<Participant> others;  // in the order in which they came, as far as it was seen
  bool single_editor = false;       // only the one editor may commit
  std::string editor_id;            // own_id, another one's, or empty: nobody
  bool is_current = false;          // false: the connection is lost, and this is how it was before

  // Null: not among the others.
  const Participant* Find(const std::string& id) const;
  bool edits_self() const { return single_editor && !own_id.empty() && editor_id == own_id; }
  bool may_edit() const { return !single_editor || edits_self(); }
};

// What has changed since the callback before, which may be several things.
struct PresenceChange {
  Attendance now;                    // whole
  std::vector<std::string> joined;   // ids, in the order of now.others
  std::vector<std::string> changed;  // likewise
  std::vector<Participant> left;     // as they were last seen
  bool editing_has_changed = false;  // single_editor or editor_id
  absl::Status ended;                // why there is nothing more to hear; else OK
};

using PresenceCallback = std::function<void(const PresenceChange&)>;

// Who edits, for people: "you", "Ada", "nobody", "everybody"; the id of whoever is not known.
std::string EditorName(const Attendance& attendance);

// An error that names a participant by id, with the name put before it.
absl::Status WithNames(const absl::Status& error, const Attendance& attendance);

}  // namespace penumbra
