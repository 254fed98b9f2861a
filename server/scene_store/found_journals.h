// Journals that a server finds when it starts: what scenes have in them, and which of them are
// needed.
//
//   const auto journals = FoundJournals::Read(directory, *directory.Journals(), {});
//   auto newer = journals.NewerThan(file);                  // to be appended to the scene's file
//   for (uint64_t number : journals.NeededBy(…)) …          // where the scene cannot be served
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/storage/commit_journal.h"
#include "server/storage/data_directory.h"
#include "server/storage/scene_file.h"

namespace penumbra {

// What is known of a scene that cannot be served.
struct JournalNeed {
  // The id of the journal that its file names; empty: none; nullopt: the file does not tell.
  std::optional<std::string> named;
  std::string incarnation;  // empty: nobody knows
  Revision head = 0;        // of its file, where that can be read
};

class FoundJournals {
 public:
  struct Journal {
    uint64_t number = 0;
    uint64_t bytes = 0;   // of its files
    absl::Status status;  // of reading it; after an error there are no commits
    std::string id;       // empty: it cannot be told
    std::map<std::string, std::vector<ChainedCommit>> commits;  // by the scene's incarnation
  };

  // Leaves them as they are.
  static FoundJournals Read(const DataDirectory& directory, std::span<const uint64_t> numbers,
                            const DatabaseOptions& options);

  // Nobody knows which there are.
  static FoundJournals Unknown(absl::Status why);

  bool are_known() const { return unknown_.ok(); }
  const std::vector<Journal>& all() const { return journals_; }

  // What the journal that the file names has of the scene after the file's head.
  // Errors  kDataLoss DAMAGED: that journal is damaged or gone, or has another history; why it, or
  //         what may be it, could not be read, which tells of no damage
  absl::StatusOr<std::vector<CommitRecord>> NewerThan(const SceneFile& file) const;

  // The numbers of those in which there may be commits of the scene that are nowhere else.
  std::vector<uint64_t> NeededBy(const JournalNeed& scene) const;

 private:
  const Journal* Find(const std::string& id) const;
  absl::Status WhyMissing(const Journal* journal) const;

  absl::Status unknown_;  // why nobody knows which there are
  std::vector<Journal> journals_;
};

}  // namespace penumbra
