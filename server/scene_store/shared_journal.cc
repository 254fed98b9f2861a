#include "server/scene_store/shared_journal.h"

#include <utility>

#include "server/random_bytes.h"
#include "server/storage/durable_file.h"

namespace penumbra {
namespace {

// A journal is read as a whole at a start after a crash. Half a minute at two thousand commits a
// second.
constexpr uint64_t kMaxBytes = uint64_t{64} << 20;
constexpr std::chrono::seconds kNextTry{1};

}  // namespace

JournalInUse::~JournalInUse() {
  journal_.reset();  // closed first
  if (is_kept_) return;
  // No scene names it any more.
  if (!has_failed_ &&
      SpareLog(directory_.JournalPath(number_), directory_.SpareJournalPath()).ok()) {
    return;
  }
  directory_.RemoveJournal(number_).IgnoreError();
}

SharedJournal::SharedJournal(const DataDirectory& directory, DatabaseOptions options,
                             Logger& logger)
    : directory_(directory), options_(options), logger_(logger) {
  RemoveDurably(directory_.SpareJournalPath()).IgnoreError();  // of another time
}

SharedJournal::~SharedJournal() {
  current_.reset();
  RemoveDurably(directory_.SpareJournalPath()).IgnoreError();
}

absl::StatusOr<std::shared_ptr<JournalInUse>> SharedJournal::Current() {
  std::lock_guard lock(mutex_);
  if (current_) return current_;
  const auto now = std::chrono::steady_clock::now();
  if (!failed_.ok() && now - failed_at_ < kNextTry) return failed_;
  auto made = Make();
  failed_ = made.status();
  failed_at_ = now;
  if (made.ok()) current_ = *made;
  return made;
}

absl::StatusOr<std::shared_ptr<JournalInUse>> SharedJournal::Make() {
  if (next_number_ == 0) {
    const auto next = directory_.NextJournal();
    if (!next.ok()) return next.status();
    next_number_ = first_number_ = *next;
  }
  const uint64_t number = next_number_++;
  auto journal = CommitJournal::Create(directory_.JournalPath(number), RandomBytes(16), options_,
                                       directory_.SpareJournalPath());
  if (!journal.ok()) {
    directory_.RemoveJournal(number).IgnoreError();
    return journal.status();
  }
  return std::make_shared<JournalInUse>(directory_, number, *std::move(journal));
}

absl::Status SharedJournal::Append(JournalInUse& journal, const JournalEntries& entries) {
  const absl::Status status = journal.journal_->Append(entries);
  // A full disk leaves no doubt of what is written.
  if (!status.ok() && !absl::IsResourceExhausted(status)) {
    logger_.Error("journal_failed", {{"error", std::string(status.message())}});
    journal.has_failed_ = true;
  }
  if (journal.has_failed() || journal.journal_->bytes() >= kMaxBytes) Retire(journal);
  return status;
}

bool SharedJournal::HasGiven(uint64_t number) {
  std::lock_guard lock(mutex_);
  return first_number_ != 0 && number >= first_number_;
}

void SharedJournal::Retire(const JournalInUse& journal) {
  std::shared_ptr<JournalInUse> retired;  // ends without the lock
  std::lock_guard lock(mutex_);
  if (current_.get() == &journal) retired = std::move(current_);
}

}  // namespace penumbra
