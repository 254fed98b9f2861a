// The disk's side of one scene while a server has it: appends, and begins the file anew where that
// has failed.
//
// While a scene is busy its commits go to a journal that it shares with others, and to its own file
// many at a time:
//
//   log->Append(commits, whole);                     // to the file, which may then name a journal
//   auto entered = log->EnterJournal(commits);
//   const auto written = shared.Append(*entered->journal, {entered->entries});
//   log->LeaveJournal(std::move(entered->entries), written.ok());
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "server/scene_store/shared_journal.h"
#include "server/storage/data_directory.h"
#include "server/storage/scene_file.h"

namespace penumbra {

struct SceneLogOptions {
  HistoryLimits history{};
  DatabaseOptions database{};
  // How often blobs that nothing needs are looked for, and how long they have been unused then.
  std::chrono::seconds house_interval{600};
  // How often scenes that cannot be read for now are looked at again.
  std::chrono::seconds refused_interval{5};
};

// Any thread may use it; calls wait for one another, and for the disk. None reads more at a time
// than commits can wait for: history_reading.h puts the pieces together.
class SceneLog {
 public:
  // `file` is settled and names no journal.
  SceneLog(DataDirectory& directory, SharedJournal& journals, SceneLogOptions options,
           std::unique_ptr<SceneFile> file);
  // With everything in its own file, where that can be written.
  ~SceneLog();

  const SceneIdentity& identity() const { return identity_; }

  // Returns once the commits are on disk; after an error none of them is.
  //
  // After an error of the disk it must not be asked again whether it has kept something: it may say
  // yes. The next call begins a new file with `whole`, which is everything that was acknowledged.
  // Errors  those of SceneFile
  absl::Status Append(std::span<const CommitRecord> commits,
                      const std::function<SceneState()>& whole);

  // Whether commits may go to a journal. A guess: EnterJournal says it for sure.
  bool is_in_journal() const { return is_in_journal_; }
  // The commits as entries of the journal that the scene's file names, which are going to be
  // appended to it: nothing else is until LeaveJournal tells whether they were. None: they cannot
  // go to one, at least not now, and Append is to be called. LeaveJournal waits for nobody, so that
  // whoever has written for many scenes tells all of them, also while one's history is read.
  struct Entered {
    std::shared_ptr<JournalInUse> journal;
    std::vector<JournalEntry> entries;
  };
  std::optional<Entered> EnterJournal(std::vector<CommitRecord> commits);
  void LeaveJournal(std::vector<JournalEntry> entries, bool were_written);

  // What commits need not wait for: moving what is in the journal into the file where it is much, a
  // snapshot of the head if one is due, and what SceneFile moves now and then. `is_tidying_due`:
  // there is any of this after commits that went to the journal; a guess, which waits for nobody.
  // Not between EnterJournal and LeaveJournal. Errors  those of SceneFile
  bool is_tidying_due();
  absl::Status Tidy(const std::function<SnapshotRecord()>& snapshot);
  // Moves everything into the file where nothing has come for a while. Then there is nothing of the
  // scene in a journal.
  void Rest();

  // As SceneFile's. Errors, further  kUnavailable STORAGE_FAILED: there is no file at the moment;
  //                                  kNotFound UNKNOWN_ID: it has been removed
  absl::StatusOr<std::optional<SnapshotRecord>> SnapshotFor(Revision revision);
  absl::StatusOr<std::optional<SnapshotRecord>> SnapshotAfter(Revision after);

  // The history as it is. Nothing of it is forgotten until Unpin, which each Pin that succeeds
  // asks for.
  absl::StatusOr<HistorySpan> Pin();
  void Unpin();
  absl::StatusOr<std::vector<CommitRecord>> CommitsAfter(Revision after, Revision last,
                                                         uint64_t max_bytes);

  // Removes the files. Nothing can be appended after that. Errors  kUnavailable STORAGE_FAILED
  absl::Status Remove();

 private:
  using Clock = std::chrono::steady_clock;

  // Every call begins with one of these: what LeaveJournal was told is there from then on.
  std::unique_lock<std::mutex> Lock();
  std::unique_lock<std::mutex> TryLock();  // has none where another call has it

  // With the mutex locked, as for all below.
  void TakeLeft();
  bool has_journalled(size_t times_many) const;
  bool is_snapshot_due() const;
  absl::Status BeginAnew(const SceneState& whole);
  // The file has everything when this is OK.
  absl::Status CheckFile();
  // `journal`  that the file names from then on; null: none
  absl::Status Write(std::span<const CommitRecord> commits, std::shared_ptr<JournalInUse> journal);
  void Name(std::shared_ptr<JournalInUse> journal);
  void Abandon();

  DataDirectory& directory_;
  SharedJournal& journals_;
  const SceneLogOptions options_;
  const SceneIdentity identity_;

  // What LeaveJournal was told last, until the next call takes it; none: there is nothing new.
  struct Left {
    std::vector<JournalEntry> entries;
    bool were_written = false;
  };
  std::mutex left_mutex_;  // taken after mutex_, held for a moment
  std::optional<Left> left_;

  std::mutex mutex_;
  std::unique_ptr<SceneFile> file_;  // null: writing has failed, or it is removed
  bool is_removed_ = false;
  int pins_ = 0;
  Clock::time_point last_append_{};

  // That the file names; null: none. It stays when writing has failed, until there is a new file.
  std::shared_ptr<JournalInUse> journal_;
  std::atomic<bool> is_in_journal_ = false;
  bool is_entered_ = false;
  // In the journal and not in the file yet, in their order; the file's chain ends before them.
  std::vector<CommitRecord> journalled_;
  uint64_t journalled_bytes_ = 0;
  SceneHead head_;  // with them
};

}  // namespace penumbra
