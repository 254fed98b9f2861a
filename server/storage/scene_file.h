// One scene on disk: snapshots, the commits since, and how commits were answered.
//
//   auto file = SceneFile::Create(path, identity, {});
//   file->Append(commits);      // returns once they are on disk
//   …
//   auto file = SceneFile::Open(path, {});   // checks every byte that matters
//   auto state = file->StateAt(file->head().revision);
//
// One thread at a time. Everything that is read back is held against hashes; what does not fit is
// kDataLoss DAMAGED, and then the file is left as it is.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/storage/database.h"
#include "server/storage/scene_record.h"
#include "server/storage/wal_check.h"

namespace penumbra {

// How much of the past a scene's file keeps.
struct HistoryLimits {
  // Commits that can be replayed, and that sessions can resume from, are at least these and at most
  // about twice as many.
  uint64_t commits = 1'000;
  // A whole snapshot is written when the commits since the last one take so many times its size.
  uint64_t snapshot_after_bytes = 1u << 20;
  // What deltas and snapshots take at most, the newest snapshot apart; then fewer commits are kept.
  uint64_t bytes = uint64_t{256} << 20;
  // Answers to commits with a key.
  uint64_t answers = 1'024;
};

// A snapshot and the commits after it, in their order.
struct SceneState {
  std::optional<SnapshotRecord> snapshot;  // none: the empty scene at revision 0
  std::vector<CommitRecord> commits;
  // Commits with a key up to the snapshot, of which only the answer is kept. For Create.
  std::vector<CommitRecord> answers;
};

// What of a scene's history can be told again.
struct HistorySpan {
  Revision oldest = 0;  // above 0: there is a snapshot of it
  ContentHash oldest_content;
  ContentHash oldest_chain;  // that the commit after it builds on
  SceneHead head;
  ContentHash content_hash;  // of the scene at the head
};

class SceneFile {
 public:
  // Makes the file at once whole, with `start` in it. There is none of that name.
  // Errors  those of Database, also of all below; kInvalidArgument RANGE: of a revision above
  //         2^63 - 1, also of Append
  static absl::StatusOr<std::unique_ptr<SceneFile>> Create(const std::string& path,
                                                           const SceneIdentity& identity,
                                                           const DatabaseOptions& options,
                                                           const SceneState& start = {});
  static absl::StatusOr<std::unique_ptr<SceneFile>> Open(const std::string& path,
                                                         const DatabaseOptions& options);
  // What `journal` would say, also of a file that is damaged elsewhere and stays as it is.
  static absl::StatusOr<std::string> NamedJournal(const std::string& path,
                                                  const DatabaseOptions& options);

  const SceneIdentity& identity() const { return identity_; }
  const SceneHead& head() const { return head_; }
  // The log's end was incomplete when the file was opened, and has been left out.
  bool had_torn_tail() const { return had_torn_tail_; }
  // The id of the journal that may have commits after the head; empty: there are none.
  const std::string& journal() const { return journal_; }
  // Of consecutive revisions after the head; there may be none. From here on there may be more in
  // `journal`, in that one only. All of this is on disk when it returns; after an error none is.
  absl::Status Append(std::span<const CommitRecord> commits, const std::string& journal = "");
  // Keeps `snapshot`, of the head, and forgets what is older than the limits ask for.
  absl::Status AppendSnapshot(const SnapshotRecord& snapshot, const HistoryLimits& limits);
  // Once so many commits with so many bytes of deltas have been appended as well.
  bool is_snapshot_due(const HistoryLimits& limits, uint64_t commits = 0, uint64_t bytes = 0) const;
  // Moves what is in the log into the file where the log has grown long enough: at a length of its
  // own for each file, so that files that grow alike do not keep the disk busy together.
  absl::Status CheckpointIfDue();
  // Puts what was found in the file when it was opened on disk for sure: it may have been read from
  // the system's memory. From here on the file is of the newest format, and is tidied up when it is
  // closed.
  absl::Status Settle();
  // Writes nothing any more, when it is closed either: after an error of the disk.
  void Abandon() { database_.CheckpointOnClose(false); }

  // From where the scene at `revision` is made: the newest snapshot that is no newer; none: the
  // empty scene. Errors, further, also of the next  kOutOfRange COMPACTED: it is older than what
  //                                                 is kept; FUTURE_BASE: newer than the head
  absl::StatusOr<std::optional<SnapshotRecord>> SnapshotFor(Revision revision);
  // The same, and all commits since then.
  absl::StatusOr<SceneState> StateAt(Revision revision);
  // The oldest revision that StateAt can make.
  absl::StatusOr<Revision> OldestRevision();
  // Commits after a revision that can be replayed, in their order.
  absl::StatusOr<std::vector<CommitRecord>> History(Revision after);
  // From the oldest revision that StateAt can make to the head.
  absl::StatusOr<HistorySpan> Span();
  // Commits after a revision up to another in their order: one at least, where there is one, and no
  // more than have `max_bytes` of deltas.
  absl::StatusOr<std::vector<CommitRecord>> CommitsAfter(Revision after, Revision last,
                                                         uint64_t max_bytes);
  // Commits with a key, with the deltas left out, oldest first: at most limits.answers of them.
  absl::StatusOr<std::vector<CommitRecord>> Answers(const HistoryLimits& limits);
  // The oldest snapshot after a revision; none: there is none.
  absl::StatusOr<std::optional<SnapshotRecord>> SnapshotAfter(Revision after);

 private:
  explicit SceneFile(Database database);
  absl::Status Begin(const SceneState& start);
  absl::Status Verify();
  absl::Status ReadIdentity();
  absl::Status VerifySnapshots();
  absl::Status VerifyCommits();
  absl::Status Upgrade();
  absl::Status WriteHead(const SceneHead& head, const std::string& journal);
  absl::Status Insert(const CommitRecord& commit, bool with_delta, SceneHead& head);
  absl::Status Insert(const SnapshotRecord& snapshot, const ContentHash& chain);
  absl::StatusOr<std::optional<Revision>> NewBase(const HistoryLimits& limits);
  absl::Status Forget(const HistoryLimits& limits);
  absl::Status CountSinceSnapshot();

  Database database_;
  // What every commit takes; none: not used yet.
  std::optional<Statement> insert_commit_;
  std::optional<Statement> update_head_;
  SceneIdentity identity_;
  int64_t format_ = 0;
  SceneHead head_;
  std::string journal_;
  bool had_torn_tail_ = false;
  // Since the newest snapshot.
  uint64_t commits_since_ = 0;
  uint64_t bytes_since_ = 0;
  uint64_t snapshot_bytes_ = 0;
  int checkpoint_pages_;  // of the log, from which on it is moved
};

}  // namespace penumbra
