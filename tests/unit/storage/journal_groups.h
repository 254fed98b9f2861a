// What tests write to journals, and what they hold against what is found there.
//
//   JournalGroups groups;                                // of two scenes
//   journal->Append(groups.Next().entries());            // ten times, say
//   TextsOf(*found) == groups.After(10);
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "server/storage/commit_journal.h"
#include "tests/support/scene_records.h"

namespace penumbra::testing {

// Commits of one scene, chained one to another.
class Chain {
 public:
  explicit Chain(std::string incarnation) : incarnation_(std::move(incarnation)) {}
  std::vector<JournalEntry> Next(int count) {
    std::vector<JournalEntry> entries;
    for (int i = 0; i < count; ++i) {
      const CommitRecord commit = CommitAt(++revision_);
      const ChainLink link = LinkOf(chain_, commit);
      chain_ = link.chain;
      entries.push_back({incarnation_, {commit, link}});
    }
    return entries;
  }

 private:
  const std::string incarnation_;
  Revision revision_ = 0;
  ContentHash chain_ = HashOfBytes("where it begins");
};

using Texts = std::map<std::string, std::vector<std::string>>;  // by incarnation

inline std::string TextOf(const ChainedCommit& chained) {
  return TextOf({.commits = {chained.commit}}) + chained.link.chain.hex();
}

inline Texts TextsOf(const FoundJournal& journal) {
  Texts texts;
  for (const auto& [incarnation, commits] : journal.commits) {
    for (const ChainedCommit& chained : commits) texts[incarnation].push_back(TextOf(chained));
  }
  return texts;
}

// One to three commits of Ada's scene and two of Bob's at a time, which are written together.
class JournalGroups {
 public:
  struct Group {
    std::vector<JournalEntry> ada, bob;
    JournalEntries entries() const { return {ada, bob}; }
  };
  Group Next() {
    const int number = static_cast<int>(texts_.size()) - 1;
    Group group{.ada = ada_.Next(1 + number % 3), .bob = bob_.Next(2)};
    Texts texts = texts_.back();
    for (const auto* entries : {&group.ada, &group.bob}) {
      for (const JournalEntry& entry : *entries) {
        texts[entry.incarnation].push_back(TextOf(entry.chained));
      }
    }
    texts_.push_back(std::move(texts));
    return group;
  }
  // All that was in the first `count` groups.
  const Texts& After(size_t count) const { return texts_.at(count); }
  size_t count() const { return texts_.size() - 1; }

 private:
  Chain ada_{"ada"}, bob_{"bob"};
  std::vector<Texts> texts_ = std::vector<Texts>(1);  // after 0, 1, … groups
};

}  // namespace penumbra::testing
