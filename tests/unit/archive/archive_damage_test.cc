// Files of archives: as they were written, or refused with the place. Row D04 of the catalogue for
// archives.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "client/session/scene_archive.h"
#include "proto/archive/archive_file_reader.h"
#include "proto/archive/archive_file_writer.h"
#include "render/scene/field_error.h"
#include "tests/support/small_archive.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

class ArchiveDamageTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto writer = ArchiveFileWriter::Create(path_).value();
    for (const auto& record : SmallArchive(7)) ASSERT_EQ(writer->Write(record), absl::OkStatus());
    ASSERT_FALSE(std::filesystem::exists(path_)) << "not before it is whole";
    ASSERT_EQ(writer->Finish(), absl::OkStatus());
    std::ifstream file(path_, std::ios::binary);
    bytes_ = {std::istreambuf_iterator<char>(file), {}};
    ASSERT_EQ(bytes_.size(), writer->size_bytes());
  }

  absl::StatusOr<ArchiveInfo> Read(const std::string& bytes) {
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << bytes;
    return ReadArchive(path_);
  }

  const TemporaryFolder folder_;
  const std::string path_ = folder_ / "studio.penumbra";
  std::string bytes_;
};

TEST_F(ArchiveDamageTest, WholeItTellsEveryRevision) {
  std::vector<Revision> revisions;
  std::string bases;
  const auto info = ReadArchive(path_, {.on_base =
                                            [&](const auto& scene) {
                                              bases += std::to_string(scene->revision());
                                              return absl::OkStatus();
                                            },
                                        .on_change =
                                            [&](const ArchivedChange& change) {
                                              revisions.push_back(change.scene->revision());
                                              EXPECT_EQ(change.delta.upsert_instances.size(), 1u);
                                              EXPECT_EQ(change.author, "tester");
                                              return absl::OkStatus();
                                            }});
  ASSERT_EQ(info.status(), absl::OkStatus());
  EXPECT_EQ(bases, "7");
  EXPECT_EQ(revisions, (std::vector<Revision>{8, 9, 10}));
  EXPECT_EQ(info->scene->revision(), 10u);
  EXPECT_EQ(info->blobs.size(), 1u);
  EXPECT_EQ(info->file_bytes, bytes_.size());
}

TEST_F(ArchiveDamageTest, D04EveryFlippedBitIsFoundWithItsPlace) {
  std::mt19937 random(7);
  for (size_t at = 0; at < bytes_.size(); ++at) {
    std::string flipped = bytes_;
    flipped[at] = static_cast<char>(flipped[at] ^ (1 << (random() % 8)));
    const auto info = Read(flipped);
    ASSERT_FALSE(info.ok()) << "byte " << at;
    EXPECT_THAT(std::string(info.status().message()), StartsWith(path_)) << at;
    if (at < 19) continue;  // of the first line
    ASSERT_EQ(ErrorReason(info.status()), "DAMAGED") << info.status();
    uint64_t named = 0;
    ASSERT_EQ(std::sscanf(info.status().message().data() + path_.size(), ": byte %lu", &named), 1);
    EXPECT_LE(named, at) << "the record begins before its damage";
  }
}

TEST_F(ArchiveDamageTest, D03EveryCutIsFound) {
  for (size_t size = 0; size < bytes_.size(); size += 3) {
    ASSERT_FALSE(Read(bytes_.substr(0, size)).ok()) << size;
  }
  EXPECT_THAT(std::string(Read(bytes_ + "x").status().message()), HasSubstr("after the end"));
}

TEST_F(ArchiveDamageTest, D04PiecesExchangedOrLeftOutAreFound) {
  std::mt19937 random(11);
  for (int i = 0; i < 500; ++i) {
    std::string changed = bytes_;
    const size_t length = 1 + random() % 200;
    const size_t a = random() % (bytes_.size() - length), b = random() % (bytes_.size() - length);
    if (i % 2 == 0) {
      changed.erase(a, length);
    } else {
      std::swap_ranges(changed.begin() + static_cast<ptrdiff_t>(a),
                       changed.begin() + static_cast<ptrdiff_t>(a + length),
                       changed.begin() + static_cast<ptrdiff_t>(b));
    }
    if (changed == bytes_) continue;
    EXPECT_FALSE(Read(changed).ok()) << a << ' ' << b << ' ' << length;
  }
}

TEST_F(ArchiveDamageTest, OtherFilesAreNoArchives) {
  EXPECT_EQ(ErrorReason(Read("glTF").status()), "ARCHIVE_FORMAT");
  EXPECT_EQ(ErrorReason(Read("PENUMBRA ARCHIVE 2\n" + bytes_.substr(19)).status()), "VERSION");
  EXPECT_EQ(ReadArchive(folder_ / "none").status().code(), absl::StatusCode::kNotFound);
  // Sealed, and still no scene: somebody made it up.
  auto records = SmallArchive(7);
  records[3].mutable_base()->mutable_delta()->mutable_upsert_lights()->at(0).set_id("lump");
  auto writer = ArchiveFileWriter::Create(path_).value();
  for (const auto& record : records) ASSERT_EQ(writer->Write(record), absl::OkStatus());
  ASSERT_EQ(writer->Finish(), absl::OkStatus());
  const auto made_up = ReadArchive(path_);
  EXPECT_EQ(ErrorReason(made_up.status()), "HASH_MISMATCH");
  EXPECT_THAT(std::string(made_up.status().message()), HasSubstr("record 4: content_hash: found "));
}

TEST_F(ArchiveDamageTest, WhatIsNotFinishedLeavesWhatWasThere) {
  {
    auto writer = ArchiveFileWriter::Create(path_).value();
    ASSERT_EQ(writer->Write(SmallArchive()[0]), absl::OkStatus());
  }
  EXPECT_EQ(ReadArchive(path_).status(), absl::OkStatus());
  EXPECT_FALSE(std::filesystem::exists(path_ + ".part"));
}

}  // namespace
}  // namespace penumbra::testing
