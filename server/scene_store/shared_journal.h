// The journal that commits of busy scenes go to. When it is long another takes its place; scenes
// that name the old one go on with it until they have much in it, each in its own time.
//
//   auto journal = shared.Current();   // to be named in a scene's file
//   shared.Append(**journal, entries); // from then on
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "absl/status/statusor.h"
#include "server/log/logger.h"
#include "server/storage/commit_journal.h"
#include "server/storage/data_directory.h"

namespace penumbra {

// A journal while some scene's file names it; whoever has a share of it is such a scene's log. With
// the last share its file is removed, and its log is there for the next journal.
class JournalInUse {
 public:
  JournalInUse(const DataDirectory& directory, uint64_t number,
               std::unique_ptr<CommitJournal> journal)
      : directory_(directory), number_(number), journal_(std::move(journal)) {}
  ~JournalInUse();

  const std::string& id() const { return journal_->id(); }
  // Nothing can be appended any more.
  bool has_failed() const { return has_failed_; }
  // For a scene that goes while its file names this journal: what is in it is needed later.
  void Keep() { is_kept_ = true; }

 private:
  friend class SharedJournal;

  const DataDirectory& directory_;
  const uint64_t number_;
  std::unique_ptr<CommitJournal> journal_;
  std::atomic<bool> has_failed_ = false;
  std::atomic<bool> is_kept_ = false;
};

// Any thread may use it; one at a time appends.
class SharedJournal {
 public:
  SharedJournal(const DataDirectory& directory, DatabaseOptions options, Logger& logger);
  ~SharedJournal();

  // What scenes are to name; makes one where there is none. Where that has failed, not again within
  // a second. Errors  those of CommitJournal
  absl::StatusOr<std::shared_ptr<JournalInUse>> Current();

  // Puts the entries on disk. Once `journal` has failed or is long it is not the current one any
  // more. Not one that has failed. Errors  those of CommitJournal
  absl::Status Append(JournalInUse& journal, const JournalEntries& entries);

  // Whether a journal of that number is one of its own, and not one that was there before.
  bool HasGiven(uint64_t number);

 private:
  absl::StatusOr<std::shared_ptr<JournalInUse>> Make();  // with the lock held
  void Retire(const JournalInUse& journal);

  const DataDirectory& directory_;
  const DatabaseOptions options_;
  Logger& logger_;

  std::mutex mutex_;
  std::shared_ptr<JournalInUse> current_;  // null: none
  // Of the next one; 0: not known yet. None is given twice: a journal that ends removes its files
  // while the next is made.
  uint64_t next_number_ = 0;
  uint64_t first_number_ = 0;  // that it has given; 0: none yet
  absl::Status failed_;        // why the last one could not be made
  std::chrono::steady_clock::time_point failed_at_;
};

}  // namespace penumbra
