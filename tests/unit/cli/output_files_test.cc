#include "client/cli/output_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;

TEST(OutputFilesTest, OfAFileItTakesFilesAndNothingElse) {
  const TemporaryFolder folder;
  const std::string file = folder / "picture.png", pipe = folder / "pipe";
  std::ofstream(file) << "before";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::filesystem::create_symlink(pipe, folder / "to_pipe");
  std::filesystem::create_symlink(file, folder / "to_file");

  EXPECT_EQ(PrepareOutputFile(file), absl::OkStatus());
  EXPECT_EQ(PrepareOutputFile(folder / "to_file"), absl::OkStatus());
  EXPECT_EQ(PrepareOutputFile(folder / "new/folder/picture.png"), absl::OkStatus());
  for (const std::string& wrong : {pipe, folder / "to_pipe", folder.path()}) {
    const absl::Status status = PrepareOutputFile(wrong);
    EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition) << wrong;
    EXPECT_THAT(std::string(status.message()), HasSubstr("need a file")) << wrong;
  }
}

}  // namespace
}  // namespace penumbra::testing
