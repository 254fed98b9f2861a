#include "client/session/camera_follower.h"

#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// Of a list in an error.
constexpr size_t kMostNames = 12;

std::string Joined(std::vector<std::string> names) {
  const bool is_cut = names.size() > kMostNames;
  if (is_cut) names.resize(kMostNames);
  return absl::StrCat(absl::StrJoin(names, ", "), is_cut ? ", …" : "");
}

bool IsSame(const std::optional<View>& a, const std::optional<View>& b) {
  return Presence{.view = a} == Presence{.view = b};
}

}  // namespace

std::string WhoIsHere(const Attendance& attendance) {
  std::vector<std::string> names;
  for (const Participant& other : attendance.others) names.push_back(other.presence.display_name);
  return names.empty() ? "nobody else is here" : "here are: " + Joined(std::move(names));
}

absl::StatusOr<Participant> FindParticipant(const Attendance& attendance, const std::string& who) {
  if (const Participant* by_id = attendance.Find(who)) return *by_id;
  std::vector<const Participant*> named;
  for (const Participant& other : attendance.others) {
    if (other.presence.display_name == who) named.push_back(&other);
  }
  if (named.size() == 1) return *named[0];
  if (named.empty()) {
    return FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "participant",
                      absl::StrCat("found nobody called \"", who,
                                   "\", need somebody who is here: ", WhoIsHere(attendance)));
  }
  std::vector<std::string> ids;
  for (const Participant* participant : named) ids.push_back(participant->id);
  return FieldError(absl::StatusCode::kFailedPrecondition, "AMBIGUOUS_NAME", "participant",
                    absl::StrCat("found ", named.size(), " people called \"", who,
                                 "\", need an id, one of: ", Joined(std::move(ids))));
}

FollowedCamera CameraFollower::Hold(FollowedCamera::State state, std::string reason) {
  return {.state = state, .view = view_, .is_new = false, .reason = std::move(reason)};
}

FollowedCamera CameraFollower::Look(const Attendance& attendance) {
  using State = FollowedCamera::State;
  if (!attendance.is_current) return Hold(State::kConnecting, "the connection is lost");
  const Participant* followed = attendance.Find(followed_id_);
  absl::StatusOr<Participant> found = followed ? *followed : FindParticipant(attendance, who_);
  if (absl::IsNotFound(found.status())) {
    if (followed_id_.empty()) {
      return Hold(State::kNotHere, absl::StrCat("nobody called \"", who_, "\" is here"));
    }
    return Hold(State::kLeft, absl::StrCat(who_, " has left"));
  }
  if (!found.ok()) return Hold(State::kSeveral, std::string(found.status().message()));
  followed_id_ = found->id;
  if (!found->presence.view) {
    return Hold(State::kNoCamera, absl::StrCat(who_, " does not say what they look at"));
  }
  FollowedCamera seen{.state = State::kFollowed, .view = found->presence.view};
  seen.is_new = !IsSame(view_, seen.view);
  view_ = seen.view;
  return seen;
}

}  // namespace penumbra
