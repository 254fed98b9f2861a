// Rows D08 and D09 of the catalogue: folders that a server does not take.
#include "server/storage/data_directory.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "render/scene/field_error.h"
#include "server/storage/durable_file.h"
#include "server/storage/heads_file.h"
#include "tests/support/temporary_folder.h"

namespace {

// Of a file system that gives no file another name; 0: it does.
std::atomic<int> link_error = 0;

}  // namespace

// In place of the system's, for the whole program.
extern "C" int link(const char* from, const char* to) noexcept {
  if (link_error == 0) return ::linkat(AT_FDCWD, from, AT_FDCWD, to, 0);
  errno = link_error;
  return -1;
}

namespace penumbra::testing {
namespace {

namespace fs = std::filesystem;

void ExpectRefused(const std::string& path, const char* reason) {
  const auto directory = DataDirectory::Open(path);
  ASSERT_FALSE(directory.ok());
  EXPECT_EQ(directory.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(ErrorReason(directory.status()), reason) << directory.status();
  EXPECT_EQ(ErrorFieldPath(directory.status()), "data-dir");
}

TEST(DataDirectoryTest, IsMadeOnceAndKeepsItsIdentity) {
  const TemporaryFolder folder;
  std::string identity;
  {
    const auto made = DataDirectory::Open(folder / "data");
    ASSERT_EQ(made.status(), absl::OkStatus());
    identity = (*made)->identity();
    EXPECT_EQ(identity.size(), 16u);
    EXPECT_EQ(fs::status(folder / "data").permissions(), fs::perms::owner_all);
  }
  const auto again = DataDirectory::Open(folder / "data");
  ASSERT_EQ(again.status(), absl::OkStatus());
  EXPECT_EQ((*again)->identity(), identity);
}

TEST(DataDirectoryTest, D08NoFolderToMakeItIn) {
  const TemporaryFolder folder;
  ExpectRefused(folder / "none/data", "DATA_DIR");
  EXPECT_FALSE(fs::exists(folder / "none"));
}

TEST(DataDirectoryTest, D08AFileALinkAndAFolderOfOthers) {
  const TemporaryFolder folder;
  std::ofstream(folder / "file") << "text";
  ExpectRefused(folder / "file", "DATA_DIR");
  fs::create_directory(folder / "there");
  fs::create_symlink(folder / "there", folder / "link");
  ExpectRefused(folder / "link", "DATA_DIR");
  std::ofstream(folder / "there/letter.txt") << "not ours";
  ExpectRefused(folder / "there", "DATA_DIR_FOREIGN");
  EXPECT_FALSE(fs::exists(folder / "there/FORMAT")) << "left as it was";
}

TEST(DataDirectoryTest, D08TwoServersCannotHaveIt) {
  const TemporaryFolder folder;
  auto first = DataDirectory::Open(folder / "data");
  ASSERT_EQ(first.status(), absl::OkStatus());
  ExpectRefused(folder / "data", "DATA_DIR_LOCKED");
  // Whoever starts a second one without options hears what to do.
  const std::string message(DataDirectory::Open(folder / "data").status().message());
  const std::string data = folder / "data";
  for (const char* part : {data.c_str(), "--data-dir", "--ephemeral"}) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  }
  first->reset();
  EXPECT_EQ(DataDirectory::Open(folder / "data").status(), absl::OkStatus());
}

TEST(DataDirectoryTest, D09ANewerFormatIsLeftAlone) {
  const TemporaryFolder folder;
  ASSERT_EQ(DataDirectory::Open(folder / "data").status(), absl::OkStatus());
  const std::string newer = "penumbra-data 2 00112233445566778899aabbccddeeff\n";
  ASSERT_EQ(WriteDurably(folder / "data/FORMAT", newer), absl::OkStatus());
  ExpectRefused(folder / "data", "NEWER_FORMAT");
  EXPECT_EQ(*ReadFileIfThere(folder / "data/FORMAT"), newer);
}

TEST(DataDirectoryTest, TheNewestFileOfAScene) {
  const TemporaryFolder folder;
  const auto data = DataDirectory::Open(folder / "data").value();
  for (const uint64_t number : {1, 2, 10}) {
    std::ofstream(data->ScenePath("a.b", number)) << number;
  }
  std::ofstream(data->ScenePath("c", 3) + ".new") << "half written";
  std::ofstream(data->ScenePath("d", 1)) << 1;
  EXPECT_EQ(data->SceneFiles().value(), (std::map<std::string, uint64_t>{{"a.b", 10}, {"d", 1}}));
  EXPECT_EQ(data->NextNumber("a.b").value(), 11u);
  EXPECT_EQ(data->NextNumber("c").value(), 1u);
  ASSERT_EQ(data->RemoveScene("a.b", 2), absl::OkStatus());
  EXPECT_EQ(data->SceneFiles().value(), (std::map<std::string, uint64_t>{{"a.b", 2}, {"d", 1}}));
  ASSERT_EQ(data->RemoveScene("a.b", 0), absl::OkStatus());
  ASSERT_EQ(data->PutAside("d"), absl::OkStatus());
  EXPECT_TRUE(data->SceneFiles().value().empty());
  EXPECT_FALSE(fs::is_empty(folder / "data/removed"));
}

TEST(DataDirectoryTest, JournalsAreCopiedAsideWhereAFileHasOneName) {
  const std::vector<uint64_t> journals = {3};
  for (const int error : {0, EPERM, EOPNOTSUPP, EMLINK, EIO}) {
    const TemporaryFolder folder;
    const auto data = DataDirectory::Open(folder / "data").value();
    std::ofstream(data->JournalPath(3)) << "commits";
    std::ofstream(data->JournalPath(3) + "-wal") << "newer ones";
    link_error = error;
    const absl::Status status = data->PutAside("a", journals);
    link_error = 0;
    ASSERT_EQ(data->RemoveJournal(3), absl::OkStatus());
    EXPECT_EQ(status.ok(), error != EIO) << status;
    if (!status.ok()) continue;
    std::set<std::string> aside;
    for (const auto& file : fs::directory_iterator(folder / "data/removed")) {
      aside.insert(ReadFileIfThere(file.path().string()).value());
    }
    EXPECT_EQ(aside, (std::set<std::string>{"commits", "newer ones"})) << error;
  }
}

TEST(HeadsFileTest, SaysWhatWasWrittenOrThatItIsDamaged) {
  const TemporaryFolder folder;
  const std::string path = folder / "heads";
  EXPECT_TRUE(ReadHeads(path).value().empty());
  const KnownHeads heads{{"a", {std::string(16, '\x01'), 7}},
                         {"b.c", {std::string(16, '\xff'), uint64_t{1} << 60}}};
  ASSERT_EQ(WriteHeads(path, heads), absl::OkStatus());
  EXPECT_EQ(ReadHeads(path).value(), heads);
  const std::string text = *ReadFileIfThere(path);
  for (size_t at = 0; at < text.size(); ++at) {
    std::string flipped = text;
    flipped[at] ^= 4;
    ASSERT_EQ(WriteDurably(path, flipped), absl::OkStatus());
    EXPECT_EQ(ReadHeads(path).status().code(), absl::StatusCode::kDataLoss) << at;
  }
}

}  // namespace
}  // namespace penumbra::testing
