// Who is in a scene, what they look at and have selected, and who may edit where only one may.
//
//   auto room = presence.RoomOf(incarnation);
//   const std::string me = room->Join(listener);
//   room->Report(me, presence);
//   PresenceCursor told;
//   v1::PresenceUpdate update;
//   if (room->ChangesSince(told, me, update)) Send(update);
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "penumbra/v1/session.pb.h"
#include "server/limits.h"
#include "server/session/delay_line.h"

namespace penumbra {

// How far somebody has been told of the others: nothing yet.
struct PresenceCursor {
  uint64_t listed = 0;  // whatever the others said, up to this version
  uint64_t heard = 0;   // who left and who edits, up to this one
};

// Told that there is something new, not more often than people can see it. Must not block.
class PresenceListener {
 public:
  virtual ~PresenceListener() = default;
  virtual void OnPresenceChanged() = 0;
};

// Of one scene. Any thread may use it.
class PresenceRoom : public std::enable_shared_from_this<PresenceRoom> {
 public:
  // Cameras that move tell others as often as this; 64 people who do would otherwise wake one
  // another 100,000 times a second.
  static constexpr std::chrono::milliseconds kInterval{50};

  // 64 selected ids of 130 bytes, a name and a camera take 9 KB.
  static constexpr size_t kMostPerUpdate = 64;
  // Whatever a server's limits allow: one that is larger than this comes alone.
  static constexpr size_t kMostBytesPerUpdate = 768u << 10;

  explicit PresenceRoom(DelayLine& delay) : delay_(delay) {}

  // The newcomer's id: 128 random bits, in hexadecimal digits. Its listener is told of all that
  // others do.
  std::string Join(std::weak_ptr<PresenceListener> listener, v1::Presence presence);
  void Leave(const std::string& id);
  // In place of what it said before.
  void Report(const std::string& id, v1::Presence presence);

  // Errors  kFailedPrecondition EDITOR_PRESENT: another one edits, from whom it is not to be taken
  //         by `from_id` or, where that is empty, by `from_other`; NOT_EDITOR: it is not its to
  //         give away or to switch; kNotFound: nobody of that id
  absl::Status Control(const std::string& id, const v1::EditControl& control);
  // Errors  kFailedPrecondition NOT_EDITOR: only one may edit, and that is another, or nobody yet
  absl::Status CheckMayEdit(const std::string& id) const;

  // Writes what has changed since ChangesSince left `told` as it is, or as much as fits into a
  // message. Whoever is told everything is told it in as many updates as that takes, whatever
  // happens meanwhile. False: nothing has changed. Nobody is told of himself.
  bool ChangesSince(PresenceCursor& told, const std::string& id, v1::PresenceUpdate& update) const;
  // Whether there is more to tell than that.
  bool HasMore(const PresenceCursor& told) const;

 private:
  struct Member {
    v1::Participant participant;
    std::weak_ptr<PresenceListener> listener;
    uint64_t version = 0;  // of the newest change
  };

  // With the lock held, as for the next two.
  void Changed();
  // For people: the name and, since two may have the same, the id. "nobody" where that is so.
  std::string EditorName() const;
  // Adds those of whom something is new, oldest first. Returns up to which version that are all.
  uint64_t AddParticipants(uint64_t since, const std::string& but,
                           v1::PresenceUpdate& update) const;
  void TellAll();

  DelayLine& delay_;
  mutable std::mutex mutex_;
  uint64_t version_ = 1;
  uint64_t forgotten_ = 0;  // up to this version it is not known any more who left
  std::map<std::string, Member> members_;
  std::map<uint64_t, std::string> left_;  // by the version at which they left
  bool has_one_editor_ = false;
  std::string editor_;  // empty: nobody
  uint64_t editor_version_ = 0;
  bool is_telling_ = false;
};

// The rooms that somebody is in.
class PresenceTable {
 public:
  std::shared_ptr<PresenceRoom> RoomOf(const std::string& incarnation);

 private:
  DelayLine delay_{PresenceRoom::kInterval};
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<PresenceRoom>> rooms_;
};

// Errors  kInvalidArgument LENGTH, RANGE, BAD_ID, NON_FINITE: the field is named "presence.…"
absl::Status CheckPresence(const v1::Presence& presence, const ServerLimits& limits);

}  // namespace penumbra
