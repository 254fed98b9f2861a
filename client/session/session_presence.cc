#include "client/session/session_presence.h"

#include <utility>

namespace penumbra {

SessionPresence::SessionPresence(v1::Presence first, PresenceCallback callback,
                                 std::function<void(const v1::Presence& newest)> send)
    : callback_(std::move(callback)),
      said_(std::move(first)),
      sender_(kPresenceInterval, std::move(send)) {}

void SessionPresence::Report(const v1::Presence& presence) {
  {
    std::lock_guard lock(mutex_);
    said_ = presence;
  }
  sender_.Offer(presence);
}

Attendance SessionPresence::attendance() const {
  std::lock_guard lock(mutex_);
  return book_.now();
}

absl::Status SessionPresence::ended() const {
  std::lock_guard lock(mutex_);
  return ended_;
}

absl::Status SessionPresence::AwaitList(std::chrono::duration<double> timeout) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, timeout, [this] { return book_.now().is_current || !ended_.ok(); });
  if (!ended_.ok() || book_.now().is_current) return ended_;
  return absl::DeadlineExceededError("presence: found no list of who is here in time");
}

void SessionPresence::Close() {
  std::unique_lock lock(mutex_);
  is_closed_ = true;
  if (caller_ == std::this_thread::get_id()) return;
  changed_.wait(lock, [this] { return caller_ == std::thread::id(); });
}

v1::Presence SessionPresence::said() const {
  std::lock_guard lock(mutex_);
  return said_;
}

void SessionPresence::Begin(const std::string& own_id) {
  std::lock_guard lock(mutex_);
  book_.Begin(own_id);
  is_lost_ = false;
  changed_.notify_all();
}

bool SessionPresence::Lose() {
  std::lock_guard lock(mutex_);
  book_.Lose();
  is_lost_ = true;
  return Offer();
}

absl::StatusOr<bool> SessionPresence::Receive(const v1::PresenceUpdate& update) {
  std::lock_guard lock(mutex_);
  if (auto status = book_.Check(update); !status.ok()) return status;
  book_.Apply(update);
  return Offer();
}

bool SessionPresence::ReceiveEnd(const absl::Status& reason) {
  std::lock_guard lock(mutex_);
  book_.Lose();
  is_lost_ = true;
  ended_ = reason;
  return Offer();
}

bool SessionPresence::Offer() {
  changed_.notify_all();
  has_news_ = true;
  return !is_closed_ && !std::exchange(is_scheduled_, true);
}

void SessionPresence::Deliver() {
  std::unique_lock lock(mutex_);
  while (std::exchange(has_news_, false) && !is_closed_) {
    PresenceChange change = Difference(told_, book_.now());
    change.ended = ended_;
    const bool is_news = IsNews(change, told_);
    told_ = book_.now();
    if (!is_news || !callback_) continue;
    caller_ = std::this_thread::get_id();
    lock.unlock();
    callback_(change);
    lock.lock();
    caller_ = {};
    changed_.notify_all();
  }
  is_scheduled_ = false;
}

bool SessionPresence::has_lost_editing() const {
  std::lock_guard lock(mutex_);
  return book_.has_lost_editing();
}

void SessionPresence::NoteDone(const v1::EditControl& control) {
  std::lock_guard lock(mutex_);
  book_.NoteAnswer(control.has_take());
}

bool SessionPresence::AwaitListOf(const std::string& own_id,
                                  std::chrono::duration<double> timeout) {
  std::unique_lock lock(mutex_);
  const auto is_over = [&] { return is_lost_ || book_.now().own_id != own_id; };
  changed_.wait_for(lock, timeout, [&] { return is_over() || book_.now().is_current; });
  return !is_over() && book_.now().is_current;
}

std::optional<v1::TakeEditing> SessionPresence::EditingToRegain() const {
  std::lock_guard lock(mutex_);
  if (!book_.has_lost_editing() || !book_.now().is_current) return std::nullopt;
  v1::TakeEditing take;
  if (book_.editor_is_ghost()) {
    // Not from whoever has taken it by the time that this arrives.
    take.set_from_id(book_.now().editor_id);
    take.set_from_other(true);  // where the server does not know the other
  }
  return take;
}

bool SessionPresence::HasReached(const v1::EditControl& control) const {
  std::lock_guard lock(mutex_);
  const Attendance& now = book_.now();
  if (control.has_hand_over()) return now.editor_id == control.hand_over().participant_id();
  if (!control.has_release()) return false;
  return now.editor_id.empty() && now.single_editor == control.release().keep_single_editor();
}

}  // namespace penumbra
