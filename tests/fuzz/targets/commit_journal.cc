// A journal of commits that has been damaged: by a disk, by a crash, and by what writes right
// checksums over it. Whatever is read of it are the first of the commits that were written, each
// byte of them, in their order.

#include "server/storage/commit_journal.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tests/fuzz/kit/require.h"
#include "tests/fuzz/kit/target.h"
#include "tests/fuzz/targets/log_frames.h"
#include "tests/fuzz/targets/payload_numbers.h"
#include "tests/fuzz/targets/scratch_file.h"
#include "tests/support/scene_records.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::fuzzing {
namespace {

// Append: which scenes commit, and the deltas' bytes. Flip, cut: of which file, where, how. Frames:
// which are exchanged, taken out or doubled. Sums: made right.
enum Kind : uint8_t { kAppend, kFlip, kCut, kFrames, kSums, kKinds };

constexpr char kId[] = "0123456789abcdef";
constexpr size_t kMostAppends = 24;
constexpr std::array<const char*, 3> kScenes = {"ada", "bob", "eve"};

// The file and its log.
struct Files {
  std::string database, log;

  std::string& OneOf(uint64_t number) { return number % 4 == 0 ? database : log; }
};

void Flip(PayloadNumbers numbers, Files& files) {
  std::string& bytes = files.OneOf(numbers.Next(1));
  if (bytes.empty()) return;
  const size_t at = numbers.Next(4) % bytes.size();
  bytes[at] = static_cast<char>(bytes[at] ^ static_cast<char>(numbers.Next(1)));
}

void Cut(PayloadNumbers numbers, Files& files) {
  std::string& bytes = files.OneOf(numbers.Next(1));
  bytes.resize(std::min<size_t>(numbers.Next(4), bytes.size()));
}

void ChangeFrames(PayloadNumbers numbers, std::string& log) {
  const size_t count = FrameCount(log);
  if (count == 0) return;
  const uint64_t how = numbers.Next(1) % 3;
  const size_t a = numbers.Next(2) % count, b = numbers.Next(2) % count;
  if (how == 0) return SwapFrames(log, a, b);
  if (how == 1) return DropFrame(log, a);
  CopyFrame(log, a, b);
}

class CommitJournals final : public Target {
 public:
  std::span<const StepKind> kinds() const override { return kinds_; }
  void Run(const Script& script) override;
  std::vector<Seed> Seeds() override;

 private:
  struct Chain {
    Revision revision = 0;
    ContentHash hash = HashOfBytes("where it begins");
  };

  Files Write(const Script& script);
  std::vector<JournalEntry> EntriesOf(const std::string& payload);
  void Add(size_t scene, const std::string& delta, std::vector<JournalEntry>& entries);
  void CheckFound(const FoundJournal& found) const;

  const StepKind kinds_[kKinds] = {{"append"}, {"flip"}, {"cut"}, {"frames"}, {"sums"}};
  const testing::TemporaryFolder folder_;
  const std::string written_path_ = folder_ / "written.db";
  const std::string path_ = folder_ / "damaged.db";
  // Of the script that runs.
  std::array<Chain, kScenes.size()> chains_;
  std::vector<JournalEntry> written_;
};

void CommitJournals::Run(const Script& script) {
  chains_ = {};
  written_.clear();
  Files files = Write(script);
  for (const Step& step : script) {
    const PayloadNumbers numbers(step.payload);
    switch (step.kind % kKinds) {
      case kFlip:
        Flip(numbers, files);
        break;
      case kCut:
        Cut(numbers, files);
        break;
      case kFrames:
        ChangeFrames(numbers, files.log);
        break;
      case kSums:
        SumAnew(files.log);
        break;
    }
  }
  WriteAnew(path_, files.database);
  WriteAnew(path_ + "-wal", files.log);
  const auto found = ReadJournal(path_, {});
  Count(found.ok());
  if (!found.ok()) return RequireRefusal(found.status());
  CheckFound(*found);
}

Files CommitJournals::Write(const Script& script) {
  std::error_code error;
  for (const char* suffix : {"", "-wal"}) std::filesystem::remove(written_path_ + suffix, error);
  auto journal = CommitJournal::Create(written_path_, kId, {});
  Require(journal.ok(), "a journal can be made: " + journal.status().ToString());
  size_t appends = 0;
  for (const Step& step : script) {
    if (step.kind % kKinds != kAppend || ++appends > kMostAppends) continue;
    const std::vector<JournalEntry> entries = EntriesOf(step.payload);
    const auto status = (*journal)->Append({entries});
    Require(status.ok(), "commits can be appended: " + status.ToString());
  }
  journal->reset();
  return {BytesIn(written_path_), BytesIn(written_path_ + "-wal")};
}

// One to four commits, of the scenes that the first bytes say.
std::vector<JournalEntry> CommitJournals::EntriesOf(const std::string& payload) {
  PayloadNumbers numbers(payload);
  std::vector<JournalEntry> entries;
  for (uint64_t more = 1 + numbers.Next(1) % 4; more > 0; --more) {
    const size_t scene = numbers.Next(1) % kScenes.size();
    Add(scene, std::string(numbers.rest()), entries);
  }
  return entries;
}

void CommitJournals::Add(size_t scene, const std::string& delta,
                         std::vector<JournalEntry>& entries) {
  Chain& chain = chains_[scene];
  CommitRecord commit = testing::CommitAt(++chain.revision);
  commit.delta = delta;
  const ChainLink link = LinkOf(chain.hash, commit);
  chain.hash = link.chain;
  entries.push_back({kScenes[scene], {commit, link}});
  written_.push_back(entries.back());
}

std::string TextOf(const ChainedCommit& chained) {
  return testing::TextOf({.commits = {chained.commit}}) + chained.link.delta_hash.hex() +
         chained.link.previous.hex() + chained.link.chain.hex();
}

void CommitJournals::CheckFound(const FoundJournal& found) const {
  Require(found.id == kId, "a journal is the one that it was");
  size_t count = 0;
  for (const auto& [incarnation, commits] : found.commits) count += commits.size();
  Require(count <= written_.size(), "there are no more commits than were written");
  std::map<std::string, std::vector<ChainedCommit>> expected;
  for (size_t i = 0; i < count; ++i) {
    expected[written_[i].incarnation].push_back(written_[i].chained);
  }
  Require(expected.size() == found.commits.size(), "no scene is another");
  for (const auto& [incarnation, commits] : expected) {
    const auto read = found.commits.find(incarnation);
    Require(read != found.commits.end() && read->second.size() == commits.size(),
            "what is read is the beginning of what was written");
    for (size_t i = 0; i < commits.size(); ++i) {
      Require(TextOf(read->second[i]) == TextOf(commits[i]), "no commit is another");
    }
  }
}

std::vector<Seed> CommitJournals::Seeds() {
  // Groups of one commit, of two of different scenes, and of one that takes pages of its own.
  const Script groups = {{kAppend, std::string("\x00\x00", 2) + "a delta"},
                         {kAppend, std::string("\x01\x00\x01", 3) + "another"},
                         {kAppend, std::string("\x00\x02", 2) + std::string(6'000, '.')},
                         {kAppend, std::string("\x00\x01", 2) + "the last"}};
  const auto with = [&](Script damage) {
    damage.insert(damage.begin(), groups.begin(), groups.end());
    return damage;
  };
  const Step sums{kSums, ""};
  return {
      {"whole", groups},
      {"flip", with({{kFlip, std::string("\x01\x00\x30\x00\x00\x01", 6)}})},
      {"flip, summed anew", with({{kFlip, std::string("\x01\xf0\x1f\x00\x00\x01", 6)}, sums})},
      {"flip of the file", with({{kFlip, std::string("\x00\x40\x00\x00\x00\x01", 6)}})},
      {"cut", with({{kCut, std::string("\x01\x00\x50\x00\x00", 5)}})},
      {"cut, summed anew", with({{kCut, std::string("\x01\x00\x50\x00\x00", 5)}, sums})},
      {"frames exchanged", with({{kFrames, std::string("\x00\x02\x00\x03\x00", 5)}, sums})},
      {"a frame taken out", with({{kFrames, std::string("\x01\x02\x00\x00\x00", 5)}, sums})},
      {"a frame doubled", with({{kFrames, std::string("\x02\x01\x00\x04\x00", 5)}, sums})},
  };
}

}  // namespace

Target& TheTarget() {
  static CommitJournals target;
  return target;
}

}  // namespace penumbra::fuzzing
