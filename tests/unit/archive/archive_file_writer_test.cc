// Where an archive is written to: beside what is there, in whose place it comes when it is whole.
#include "proto/archive/archive_file_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "client/session/scene_archive.h"
#include "tests/support/small_archive.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

void WriteAll(ArchiveFileWriter& writer) {
  for (const auto& record : SmallArchive(7)) ASSERT_EQ(writer.Write(record), absl::OkStatus());
}

class ArchiveFileWriterTest : public ::testing::Test {
 protected:
  size_t FilesInFolder() const {
    return static_cast<size_t>(std::distance(fs::directory_iterator(folder_.path()), {}));
  }
  void WriteArchive(const std::string& path) {
    auto writer = ArchiveFileWriter::Create(path);
    ASSERT_EQ(writer.status(), absl::OkStatus());
    WriteAll(**writer);
    ASSERT_EQ((*writer)->Finish(), absl::OkStatus());
  }

  const TemporaryFolder folder_;
  const std::string path_ = folder_ / "studio.penumbra";
};

TEST_F(ArchiveFileWriterTest, ALinkGoesOnLeadingToTheFile) {
  fs::create_directory(folder_ / "disk");
  const std::string link = folder_ / "link";
  fs::create_symlink("disk/studio.penumbra", link);  // of which there is none yet
  for (int i = 0; i < 2; ++i) {
    WriteArchive(link);
    EXPECT_TRUE(fs::is_symlink(link));
    EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(folder_ / "disk/studio.penumbra")));
    EXPECT_EQ(ReadArchive(folder_ / "disk/studio.penumbra").status(), absl::OkStatus());
  }
}

TEST_F(ArchiveFileWriterTest, WhatIsNoFileStays) {
  ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
  fs::create_symlink(path_, folder_ / "link");
  for (const std::string& path : {path_, folder_ / "link"}) {
    const auto writer = ArchiveFileWriter::Create(path);
    ASSERT_EQ(writer.status().code(), absl::StatusCode::kFailedPrecondition) << path;
    EXPECT_THAT(std::string(writer.status().message()), HasSubstr("no file"));
  }
  EXPECT_TRUE(fs::is_fifo(path_));
  EXPECT_EQ(FilesInFolder(), 2u);
}

TEST_F(ArchiveFileWriterTest, TwoOfOnePathEachWriteAllOfTheirs) {
  auto first = ArchiveFileWriter::Create(path_).value();
  WriteAll(*first);
  auto second = ArchiveFileWriter::Create(path_).value();
  ASSERT_EQ(first->Finish(), absl::OkStatus());
  EXPECT_EQ(ReadArchive(path_).status(), absl::OkStatus());
  WriteAll(*second);
  EXPECT_EQ(ReadArchive(path_).status(), absl::OkStatus()) << "until the second is finished";
  ASSERT_EQ(second->Finish(), absl::OkStatus());
  EXPECT_EQ(ReadArchive(path_).status(), absl::OkStatus());
  EXPECT_EQ(FilesInFolder(), 1u);
}

TEST_F(ArchiveFileWriterTest, AUsersFileOfSuchANameStays) {
  std::ofstream(path_ + ".part") << "mine";
  WriteArchive(path_);
  { const auto unfinished = ArchiveFileWriter::Create(path_).value(); }
  std::string kept;
  std::ifstream(path_ + ".part") >> kept;
  EXPECT_EQ(kept, "mine");
  EXPECT_EQ(FilesInFolder(), 2u) << "nothing stays of the one that was not finished";
}

}  // namespace
}  // namespace penumbra::testing
