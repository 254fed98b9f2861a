#include "client/display/image_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <vector>

namespace penumbra {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class ImageIoTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              ("image_io_" + std::to_string(getpid()) + "_" +
               testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
};

TEST_F(ImageIoTest, ExrKeepsEveryBitUnderItsChannelsName) {
  const std::vector<float> count = {0, 1, 2, 3, 4, 65535};
  const std::vector<float> red = {0.1f,     -3e-38f, 1e30f, std::numeric_limits<float>::infinity(),
                                  1.0f / 3, 0};
  const std::vector<NamedPlane> planes = {{"count", count}, {"R", red}};
  const auto path = folder_ / "floor.exr";
  ASSERT_TRUE(WriteExr(path, 3, 2, planes).ok());
  const auto read = ReadImage(path);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->width, 3);
  EXPECT_EQ(read->height, 2);
  ASSERT_EQ(read->values.size(), 2u);
  EXPECT_EQ(read->values.at("count"), count) << "row 0 first";
  EXPECT_EQ(read->values.at("R"), red);
}

TEST_F(ImageIoTest, ExrOfAPictureHasItsFourChannels) {
  const Picture picture = {
      .width = 1, .height = 2, .pixels = {Vec4(1, 2, 3, 1), Vec4(4, 5, 6, 0.5f)}};
  ASSERT_TRUE(WriteExr(folder_ / "p.exr", picture).ok());
  const auto read = ReadImage(folder_ / "p.exr");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_THAT(read->values.at("R"), ElementsAre(1, 4));
  EXPECT_THAT(read->values.at("G"), ElementsAre(2, 5));
  EXPECT_THAT(read->values.at("B"), ElementsAre(3, 6));
  EXPECT_THAT(read->values.at("A"), ElementsAre(1, 0.5f));
}

TEST_F(ImageIoTest, PngKeepsItsBytes) {
  const std::vector<uint8_t> rgb = {0, 128, 255, 1, 2, 3};
  ASSERT_TRUE(WritePng(folder_ / "a.png", 2, 1, rgb).ok());
  const auto read = ReadImage(folder_ / "a.png");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_THAT(read->values.at("G"), ElementsAre(128 / 255.0f, 2 / 255.0f));
}

TEST_F(ImageIoTest, WritesUnderAnyName) {
  EXPECT_TRUE(WritePng(folder_ / "no ending", 1, 1, std::vector<uint8_t>(3)).ok());
}

TEST_F(ImageIoTest, UnwritablePathsAreToldWithTheirName) {
  const std::vector<uint8_t> rgb(3);
  const absl::Status no_folder = WritePng(folder_ / "missing" / "a.png", 1, 1, rgb);
  EXPECT_EQ(no_folder.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(no_folder.message()), HasSubstr("missing/a.png: cannot be written"));
  EXPECT_FALSE(WritePng(folder_, 1, 1, rgb).ok()) << "a folder is not a file";
  const std::vector<float> values(1);
  const std::vector<NamedPlane> planes = {{"R", values}};
  EXPECT_EQ(WriteExr(folder_ / "missing" / "a.exr", 1, 1, planes).code(),
            absl::StatusCode::kUnavailable);
}

TEST_F(ImageIoTest, SizesMustAgree) {
  const absl::Status status = WritePng(folder_ / "a.png", 2, 2, std::vector<uint8_t>(11));
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("found 11 values, need 12"));
  const std::vector<float> values(3);
  const std::vector<NamedPlane> planes = {{"R", values}};
  EXPECT_EQ(WriteExr(folder_ / "a.exr", 2, 2, planes).code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(WriteExr(folder_ / "a.exr", 0, 2, {}).code(), absl::StatusCode::kInvalidArgument);
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

TEST_F(ImageIoTest, ReadingTellsMissingFromBroken) {
  EXPECT_EQ(ReadImage(folder_ / "none.exr").status().code(), absl::StatusCode::kNotFound);
  std::ofstream(folder_ / "broken.png") << "\x89PNG\r\n\x1a\nnot really";
  EXPECT_EQ(ReadImage(folder_ / "broken.png").status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace penumbra
