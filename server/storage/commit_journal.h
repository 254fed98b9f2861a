// Commits of many scenes, one after another in one file: those of all who wait are put on disk with
// one sync.
//
//   auto journal = CommitJournal::Create(path, id, {});
//   scene_file.Append(commits, id);       // from here on there may be more of this scene in it
//   journal->Append({…});                 // returns once they are on disk
//   …
//   auto found = ReadJournal(path, {});   // after a crash
//   found->commits[incarnation]           // those after the scene file's head are the newest
//
// A scene's file says in which journal there may be more, before there is. So whoever finds that
// journal damaged or gone knows which scenes are not whole, and that all others are.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "server/storage/database.h"
#include "server/storage/scene_rows.h"

namespace penumbra {

struct JournalEntry {
  std::string incarnation;  // of the scene
  ChainedCommit chained;
};

// Those of several scenes, one after another.
using JournalEntries = std::vector<std::span<const JournalEntry>>;

// One thread at a time.
class CommitJournal {
 public:
  // `id`     bytes that no other journal has. There is no file of that name.
  // `spare`  what SpareLog has left, if anything: it is written over, which is synced sooner than
  //          what grows
  // Errors  those of Database, also of Append
  static absl::StatusOr<std::unique_ptr<CommitJournal>> Create(const std::string& path,
                                                               const std::string& id,
                                                               const DatabaseOptions& options,
                                                               const std::string& spare = "");

  const std::string& id() const { return id_; }
  // All of them are on disk when it returns. After an error none counts as being, but they may be
  // found there; after one other than kResourceExhausted the journal must not be used any more.
  absl::Status Append(const JournalEntries& entries);
  // That the file takes, about.
  uint64_t bytes() const;

 private:
  CommitJournal(std::string id, Database database)
      : id_(std::move(id)), database_(std::move(database)) {}
  absl::Status Insert(const JournalEntry& entry, int64_t place);

  const std::string id_;
  Database database_;
  std::optional<Statement> insert_;  // none: not used yet
  int64_t place_ = 0;                // of the next entry
};

// Removes a journal that nobody has open or needs, but for its log, which is kept as `spare` with
// nothing in it. Errors  kUnavailable STORAGE_FAILED: some of it may be there yet
absl::Status SpareLog(const std::string& path, const std::string& spare);

// What a journal tells, each scene's commits in their order.
struct FoundJournal {
  std::string id;
  std::map<std::string, std::vector<ChainedCommit>> commits;  // by the scene's incarnation
};

// Leaves the file as it is.
//
// Errors  kDataLoss DAMAGED: something is not as it was written; others of Database
absl::StatusOr<FoundJournal> ReadJournal(const std::string& path, const DatabaseOptions& options);
// Its id alone, which one may tell that is damaged elsewhere. Errors  those of ReadJournal
absl::StatusOr<std::string> ReadJournalId(const std::string& path, const DatabaseOptions& options);

}  // namespace penumbra
