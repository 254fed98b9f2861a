#include "server/storage/result_files.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "render/scene/hashed_text.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kSeal = 32;

ContentHash Name(int number) { return HashedText().Add(static_cast<uint64_t>(number)).Hash(); }

class ResultFilesTest : public ::testing::Test {
 protected:
  std::unique_ptr<ResultFiles> Open(uint64_t max_bytes = 1u << 20) {
    auto files = ResultFiles::Open(folder_ / "results", max_bytes);
    EXPECT_TRUE(files.ok()) << files.status();
    return *std::move(files);
  }
  std::string PathOf(int number) { return folder_ / ("results/" + Name(number).hex()); }

  const TemporaryFolder folder_;
};

TEST_F(ResultFilesTest, WhatIsWrittenIsReadAlsoByTheNext) {
  {
    const auto files = Open();
    EXPECT_EQ(files->Write(Name(1), "one"), absl::OkStatus());
    EXPECT_EQ(files->Write(Name(2), ""), absl::OkStatus());
    EXPECT_EQ(files->Read(Name(1)), "one");
  }
  const auto files = Open();
  EXPECT_EQ(files->Read(Name(1)), "one");
  EXPECT_EQ(files->Read(Name(2)), "");
  EXPECT_EQ(files->Read(Name(3)), std::nullopt);
  EXPECT_EQ(files->bytes(), 3 + 2 * kSeal);
}

TEST_F(ResultFilesTest, AnyFlippedBitAndAnyCutIsNoticedAndTheFileGoes) {
  const std::string text = "what was computed";
  for (size_t bit = 0; bit < 8 * (text.size() + kSeal); ++bit) {
    const auto files = Open();
    ASSERT_EQ(files->Write(Name(1), text), absl::OkStatus());
    std::fstream file(PathOf(1), std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(static_cast<std::streamoff>(bit / 8));
    const char byte = static_cast<char>(file.get() ^ (1 << bit % 8));
    file.seekp(static_cast<std::streamoff>(bit / 8));
    file.put(byte);
    file.close();
    EXPECT_EQ(files->Read(Name(1)), std::nullopt) << bit;
    EXPECT_FALSE(fs::exists(PathOf(1)));
    EXPECT_EQ(files->bytes(), 0u);
  }
  for (size_t length = 0; length < text.size() + kSeal; ++length) {
    const auto files = Open();
    ASSERT_EQ(files->Write(Name(1), text), absl::OkStatus());
    fs::resize_file(PathOf(1), length);
    EXPECT_EQ(files->Read(Name(1)), std::nullopt) << length;
  }
}

TEST_F(ResultFilesTest, AFileThatSomebodyRemovedIsMissing) {
  const auto files = Open();
  ASSERT_EQ(files->Write(Name(1), "one"), absl::OkStatus());
  fs::remove(PathOf(1));
  EXPECT_EQ(files->Read(Name(1)), std::nullopt);
  EXPECT_EQ(files->Write(Name(1), "one"), absl::OkStatus());
  EXPECT_EQ(files->Read(Name(1)), "one");
}

TEST_F(ResultFilesTest, WhatWasUnusedForLongestGoesFirstAlsoAfterARestart) {
  const uint64_t each = 100 + kSeal;
  const std::string text(100, 'x');
  {
    const auto files = Open(5 * each);
    for (int i = 0; i < 5; ++i) ASSERT_EQ(files->Write(Name(i), text), absl::OkStatus());
    const auto then = fs::file_time_type::clock::now() - std::chrono::hours(1);
    for (int i = 0; i < 5; ++i) fs::last_write_time(PathOf(i), then + std::chrono::seconds(i));
    EXPECT_TRUE(files->Read(Name(0))) << "used now";
    ASSERT_EQ(files->Write(Name(5), text), absl::OkStatus());
    EXPECT_FALSE(files->Contains(Name(1)));
    EXPECT_FALSE(fs::exists(PathOf(1)));
  }
  const auto files = Open(3 * each + kSeal);
  EXPECT_EQ(files->bytes(), 3 * each);
  for (const int kept : {4, 0, 5}) EXPECT_TRUE(files->Contains(Name(kept))) << kept;
  for (const int gone : {1, 2, 3}) EXPECT_FALSE(fs::exists(PathOf(gone))) << gone;
}

TEST_F(ResultFilesTest, NoFileTakesMoreThanAQuarter) {
  const auto files = Open(4'000);
  EXPECT_EQ(files->Write(Name(1), std::string(1'000, 'x')), absl::OkStatus());
  EXPECT_FALSE(files->Contains(Name(1)));
  EXPECT_EQ(files->Write(Name(1), std::string(1'000 - kSeal, 'x')), absl::OkStatus());
  EXPECT_TRUE(files->Contains(Name(1)));
}

TEST_F(ResultFilesTest, WhatACrashLeftGoesAndWhatIsOthersStays) {
  Open();
  std::ofstream(PathOf(1) + ".new") << "half";
  std::ofstream(folder_ / "results/notes.txt") << "mine";
  fs::create_directory(PathOf(2));
  const auto files = Open();
  EXPECT_FALSE(fs::exists(PathOf(1) + ".new"));
  EXPECT_TRUE(fs::exists(folder_ / "results/notes.txt"));
  EXPECT_EQ(files->Read(Name(2)), std::nullopt);
}

TEST_F(ResultFilesTest, AFolderThatIsAFileIsAnError) {
  std::ofstream(folder_ / "results") << "no folder";
  EXPECT_FALSE(ResultFiles::Open(folder_ / "results", 1'000).ok());
}

}  // namespace
}  // namespace penumbra::testing
