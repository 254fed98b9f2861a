// Somebody's camera, for as long as they are here, and their last one after that.
//
//   CameraFollower follower("Ada");
//   const FollowedCamera seen = follower.Look(change.now);
//   if (seen.view) Draw(*seen.view);
//   if (!seen.is_followed()) Say(seen.reason);   // "Ada has left"
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "client/session/presence.h"

namespace penumbra {

struct FollowedCamera {
  enum class State {
    kFollowed,
    kNoCamera,   // they are here, and do not say what they look at
    kNotHere,    // nobody of that name has been here yet
    kSeveral,    // several of that name are here; an id is needed
    kLeft,       // they were here
    kConnecting  // our own connection is lost
  };
  State state = State::kNotHere;
  std::optional<View> view;  // unless followed the last one, if there was any
  bool is_new = false;       // the view is not the one of the look before
  std::string reason;        // why it is not followed; else empty

  bool is_followed() const { return state == State::kFollowed; }
};

class CameraFollower {
 public:
  // `who` is a participant's id, or a name. Somebody of that name who comes back, as after a lost
  // connection of theirs, is followed again.
  explicit CameraFollower(std::string who) : who_(std::move(who)) {}

  // What is to be seen now.
  FollowedCamera Look(const Attendance& attendance);

 private:
  FollowedCamera Hold(FollowedCamera::State state, std::string reason);

  const std::string who_;
  std::string followed_id_;  // empty: nobody yet
  std::optional<View> view_;
};

// "here are: Ada, Bob", a dozen of them at most, or "nobody else is here".
std::string WhoIsHere(const Attendance& attendance);

// The one participant whose id or name is `who`.
//
// Errors  kNotFound UNKNOWN_ID: nobody; the error names those who are here; kFailedPrecondition
//         AMBIGUOUS_NAME: several of that name; it gives their ids
absl::StatusOr<Participant> FindParticipant(const Attendance& attendance, const std::string& who);

}  // namespace penumbra
