// A scene's file with bits flipped, cut, or pieces of it exchanged: what it tells is what was
// written, or it tells nothing. Row D03 and D04 of the catalogue.

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "server/storage/durable_file.h"
#include "server/storage/scene_file.h"
#include "tests/support/scene_records.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

constexpr Revision kSnapshot = 40;
constexpr Revision kHead = 60;

struct Image {
  std::string file;
  std::string log;  // empty: the file was closed
};

// What became of an image.
enum class Fate { kSame, kShorter, kRefused, kWrong };

class SceneFileDamageTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto file = SceneFile::Create(path_, StudioIdentity(), {}).value();
    for (Revision revision = 1; revision <= kHead; revision += 2) {
      ASSERT_EQ(file->Append(CommitsBetween(revision, revision + 1)), absl::OkStatus());
      if (revision + 1 == kSnapshot) {
        ASSERT_EQ(file->AppendSnapshot(SnapshotAt(kSnapshot), {}), absl::OkStatus());
      }
    }
    crashed_ = {*ReadFileIfThere(path_), *ReadFileIfThere(path_ + "-wal")};
    ASSERT_EQ(file->Settle(), absl::OkStatus());
    file.reset();
    closed_ = {*ReadFileIfThere(path_), ""};
    ASSERT_FALSE(crashed_.log.empty());
    ASSERT_GT(closed_.file.size(), 10'000u);
  }

  Fate FateOf(const Image& image) {
    // Not synced, as these are read at once.
    Write(path_, image.file);
    Write(path_ + "-wal", image.log);
    const auto file = SceneFile::Open(path_, {});
    if (!file.ok()) {
      // Left as it was.
      EXPECT_EQ(*ReadFileIfThere(path_), image.file);
      return Fate::kRefused;
    }
    const Revision head = (*file)->head().revision;
    const auto state = (*file)->StateAt(head);
    const auto history = (*file)->History(0);
    if (!state.ok() || !history.ok()) return Fate::kRefused;
    const SceneState expected = head < kSnapshot
                                    ? SceneState{.commits = CommitsBetween(1, head)}
                                    : SceneState{.snapshot = SnapshotAt(kSnapshot),
                                                 .commits = CommitsBetween(kSnapshot + 1, head)};
    // The snapshot may be what is lost, for it is a transaction too.
    const bool is_expected =
        TextOf(*state) == TextOf(expected) ||
        (head == kSnapshot && TextOf(*state) == TextOf({.commits = CommitsBetween(1, head)}));
    if (!is_expected || history->size() != head) return Fate::kWrong;
    if (head == kHead) return Fate::kSame;
    return (*file)->had_torn_tail() ? Fate::kShorter : Fate::kWrong;
  }

  static void Write(const std::string& path, const std::string& bytes) {
    std::filesystem::remove(path);
    if (bytes.empty()) return;
    std::FILE* out = std::fopen(path.c_str(), "wb");
    ASSERT_NE(out, nullptr);
    ASSERT_EQ(std::fwrite(bytes.data(), 1, bytes.size(), out), bytes.size());
    std::fclose(out);
  }

  TemporaryFolder folder_;
  const std::string path_ = folder_ / "studio.db";
  Image crashed_;
  Image closed_;
  std::mt19937 random_{7};
};

TEST_F(SceneFileDamageTest, UndamagedItIsWhole) {
  EXPECT_EQ(FateOf(crashed_), Fate::kSame);
  EXPECT_EQ(FateOf(closed_), Fate::kSame);
}

TEST_F(SceneFileDamageTest, D04TheJournalThatADamagedOneNamesIsToldOrNot) {
  ASSERT_EQ(SceneFile::Open(path_, {}).value()->Append({}, "a journal"), absl::OkStatus());
  const std::string file = *ReadFileIfThere(path_), log = *ReadFileIfThere(path_ + "-wal");
  int told = 0;
  for (int i = 0; i < 500; ++i) {
    std::string flipped = file;
    flipped[random_() % file.size()] ^= 4;
    Write(path_, flipped);
    Write(path_ + "-wal", log);
    if (SceneFile::Open(path_, {}).ok()) continue;
    const auto named = SceneFile::NamedJournal(path_, {});
    EXPECT_EQ(named.value_or("a journal"), "a journal") << i;
    told += named.ok();
    EXPECT_EQ(*ReadFileIfThere(path_), flipped);
    EXPECT_EQ(*ReadFileIfThere(path_ + "-wal"), log);
  }
  EXPECT_GT(told, 100);
}

TEST_F(SceneFileDamageTest, D04FlippedBitsInTheFile) {
  size_t refused = 0;
  for (int i = 0; i < 3'000; ++i) {
    Image image = closed_;
    const size_t at = random_() % image.file.size();
    image.file[at] = static_cast<char>(image.file[at] ^ (1 << (random_() % 8)));
    const Fate fate = FateOf(image);
    EXPECT_TRUE(fate == Fate::kSame || fate == Fate::kRefused) << "byte " << at;
    refused += fate == Fate::kRefused;
  }
  EXPECT_GT(refused, 1'000u) << "most bytes matter";
}

TEST_F(SceneFileDamageTest, D04FlippedBitsInTheLog) {
  size_t refused = 0, shorter = 0;
  for (int i = 0; i < 3'000; ++i) {
    Image image = crashed_;
    const size_t at = random_() % image.log.size();
    image.log[at] = static_cast<char>(image.log[at] ^ (1 << (random_() % 8)));
    const Fate fate = FateOf(image);
    EXPECT_NE(fate, Fate::kWrong) << "byte " << at;
    refused += fate == Fate::kRefused;
    shorter += fate == Fate::kShorter;
  }
  EXPECT_GT(refused, 2'000u) << "what follows a damaged transaction was acknowledged";
  EXPECT_LT(shorter, 500u) << "only the last transaction may be taken for a torn one";
}

// With the log cut between two transactions nothing is to be seen here; server/storage/heads_file.h
// is for that.
TEST_F(SceneFileDamageTest, D03CutFiles) {
  for (int i = 0; i < 1'000; ++i) {
    Image image = closed_;
    image.file.resize(random_() % image.file.size());
    EXPECT_EQ(FateOf(image), Fate::kRefused) << image.file.size();
  }
  size_t at_an_end = 0;
  for (int i = 0; i < 2'000; ++i) {
    Image image = crashed_;
    image.log.resize(random_() % image.log.size());
    const Fate fate = FateOf(image);
    if (fate == Fate::kWrong) ++at_an_end;
  }
  EXPECT_LT(at_an_end, 20u);
}

TEST_F(SceneFileDamageTest, D04ZeroedAndExchangedPages) {
  for (int i = 0; i < 1'000; ++i) {
    Image image = closed_;
    const size_t pages = image.file.size() / 4096;
    const size_t page = random_() % pages;
    if (i % 2 == 0) {
      std::fill_n(image.file.begin() + static_cast<ptrdiff_t>(page * 4096), 4096, '\0');
    } else {
      const size_t other = random_() % pages;
      std::swap_ranges(image.file.begin() + static_cast<ptrdiff_t>(page * 4096),
                       image.file.begin() + static_cast<ptrdiff_t>(page * 4096 + 4096),
                       image.file.begin() + static_cast<ptrdiff_t>(other * 4096));
    }
    const Fate fate = FateOf(image);
    EXPECT_TRUE(fate == Fate::kSame || fate == Fate::kRefused) << "page " << page;
  }
}

TEST_F(SceneFileDamageTest, TheLogOfAnotherFileIsNotTakenForItsOwn) {
  const std::string other_path = folder_ / "other.db";
  SceneIdentity other = StudioIdentity();
  other.scene_id = "other";
  auto file = SceneFile::Create(other_path, other, {}).value();
  ASSERT_EQ(file->Append(CommitsBetween(1, 80)), absl::OkStatus());
  Image image = closed_;
  image.log = *ReadFileIfThere(other_path + "-wal");
  EXPECT_NE(FateOf(image), Fate::kWrong);
}

}  // namespace
}  // namespace penumbra::testing
