#include "server/scene_store/found_journals.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

namespace penumbra {
namespace {

uint64_t BytesOf(const std::string& path) {
  std::error_code error;
  const uint64_t bytes = std::filesystem::file_size(path, error);
  return error ? 0 : bytes;
}

FoundJournals::Journal ReadOne(uint64_t number, const std::string& path,
                               const DatabaseOptions& options) {
  FoundJournals::Journal journal{.number = number, .bytes = BytesOf(path) + BytesOf(path + "-wal")};
  auto found = ReadJournal(path, options);
  journal.status = found.status();
  if (found.ok()) {
    journal.id = std::move(found->id);
    journal.commits = std::move(found->commits);
  } else {
    journal.id = ReadJournalId(path, options).value_or(std::string());
  }
  return journal;
}

// A file that was exchanged for an older one names a journal of its time.
bool HasNewer(const FoundJournals::Journal& journal, const JournalNeed& scene) {
  const auto commits = journal.commits.find(scene.incarnation);
  return commits != journal.commits.end() && !commits->second.empty() &&
         commits->second.back().commit.revision > scene.head;
}

}  // namespace

FoundJournals FoundJournals::Read(const DataDirectory& directory, std::span<const uint64_t> numbers,
                                  const DatabaseOptions& options) {
  FoundJournals found;
  for (const uint64_t number : numbers) {
    found.journals_.push_back(ReadOne(number, directory.JournalPath(number), options));
  }
  return found;
}

FoundJournals FoundJournals::Unknown(absl::Status why) {
  FoundJournals unknown;
  unknown.unknown_ = std::move(why);
  return unknown;
}

const FoundJournals::Journal* FoundJournals::Find(const std::string& id) const {
  // A sound copy may have been put beside a damaged one.
  const Journal* found = nullptr;
  for (const Journal& journal : journals_) {
    if (journal.id == id && (!found || !found->status.ok())) found = &journal;
  }
  return found;
}

absl::StatusOr<std::vector<CommitRecord>> FoundJournals::NewerThan(const SceneFile& file) const {
  std::vector<CommitRecord> newer;
  if (file.journal().empty()) return newer;
  const Journal* const journal = Find(file.journal());
  if (!journal || !journal->status.ok()) return WhyMissing(journal);
  const auto commits = journal->commits.find(file.identity().incarnation);
  if (commits == journal->commits.end()) return newer;
  SceneHead head = file.head();
  for (const auto& [commit, link] : commits->second) {
    if (commit.revision <= head.revision) continue;
    if (commit.revision != head.revision + 1 || link.previous != head.chain) {
      return Damaged("a journal with commits of another history");
    }
    head = {.revision = commit.revision, .chain = link.chain};
    newer.push_back(commit);
  }
  return newer;
}

absl::Status FoundJournals::WhyMissing(const Journal* journal) const {
  if (!unknown_.ok()) return unknown_;
  for (const Journal& other : journals_) {
    const bool may_be_it = journal ? &other == journal : other.id.empty();
    if (may_be_it && !other.status.ok() && !absl::IsDataLoss(other.status)) return other.status;
  }
  return Damaged("commits in a journal that is damaged or gone");
}

std::vector<uint64_t> FoundJournals::NeededBy(const JournalNeed& scene) const {
  const bool names_one = scene.named && !scene.named->empty();
  const bool is_there = names_one && Find(*scene.named) != nullptr;
  std::vector<uint64_t> needed;
  for (const Journal& journal : journals_) {
    bool is_needed = names_one && journal.id == *scene.named;
    if (journal.status.ok()) {
      is_needed |= HasNewer(journal, scene) || (!scene.named && scene.incarnation.empty());
    } else {
      // One that does not tell its id may be the one that is missing, and one that cannot be read
      // for now a sound copy of one that is damaged.
      is_needed |= !scene.named || !absl::IsDataLoss(journal.status) ||
                   (names_one && !is_there && journal.id.empty());
    }
    if (is_needed) needed.push_back(journal.number);
  }
  return needed;
}

}  // namespace penumbra
