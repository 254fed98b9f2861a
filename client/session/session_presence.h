// A session's share in presence: what its user says, what is heard of others, and whom to tell.
//
// The reader puts in what comes; whichever thread runs the session's job calls back with what has
// changed since the callback before. What comes faster than the callback takes it melts together.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "absl/status/statusor.h"
#include "client/session/attendance_book.h"
#include "client/session/newest_sender.h"
#include "client/session/presence.h"
#include "penumbra/v1/session.pb.h"

namespace penumbra {

class SessionPresence {
 public:
  // `callback` may be null. `send` as for NewestSender.
  SessionPresence(v1::Presence first, PresenceCallback callback,
                  std::function<void(const v1::Presence& newest)> send);

  // Of its owner.
  void Report(const v1::Presence& presence);
  Attendance attendance() const;
  absl::Status ended() const;  // why nothing more is heard; else OK
  // Waits until everybody is known on the connection that there is.
  absl::Status AwaitList(std::chrono::duration<double> timeout);
  // No callback runs after this; waits for one that does, unless it is the caller.
  void Close();
  // No `send` runs after this; waits for one that does.
  void StopSending() { sender_.Close(); }

  // Of the session. What the hello of another connection says.
  v1::Presence said() const;
  void Begin(const std::string& own_id);
  // True if a job must Deliver(), as for the next two.
  bool Lose();
  // Errors  those of AttendanceBook::Check: the session must end
  absl::StatusOr<bool> Receive(const v1::PresenceUpdate& update);
  bool ReceiveEnd(const absl::Status& reason);
  void Deliver();

  bool has_lost_editing() const;
  // What `control` asks for is so, by its answer or by the list.
  void NoteDone(const v1::EditControl& control);
  // False: the connection on which we are `own_id` is lost, or no list comes in time.
  bool AwaitListOf(const std::string& own_id, std::chrono::duration<double> timeout);
  // How to take editing back that was lost with a connection. None: there is none to take back, or
  // somebody else has taken it.
  std::optional<v1::TakeEditing> EditingToRegain() const;
  // Whether what `control` asks for is so, as far as is known.
  bool HasReached(const v1::EditControl& control) const;

 private:
  bool Offer();  // with the lock held

  const PresenceCallback callback_;
  mutable std::mutex mutex_;  // guards all but the sender
  std::condition_variable changed_;
  v1::Presence said_;
  AttendanceBook book_;
  Attendance told_;  // that the callback knows
  absl::Status ended_;
  bool is_lost_ = false;       // the connection that began last
  bool has_news_ = false;      // perhaps
  bool is_scheduled_ = false;  // a job is going to look, or is looking, for news
  bool is_closed_ = false;
  std::thread::id caller_;  // the thread inside the callback; none: default
  NewestSender sender_;     // destroyed first
};

}  // namespace penumbra
