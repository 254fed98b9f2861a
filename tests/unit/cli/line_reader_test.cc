#include "client/cli/line_reader.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <future>
#include <string>
#include <vector>

#include "render/scene/field_error.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

std::vector<std::string> LinesOf(const std::string& text) {
  const TemporaryFolder folder;
  const std::string path = folder / "lines";
  std::ofstream(path, std::ios::binary) << text;
  const auto reader = LineReader::Open(path).value();
  std::vector<std::string> lines;
  while (auto line = reader->Next({})) lines.push_back(*std::move(line));
  return lines;
}

TEST(LineReaderTest, LinesOfAFile) {
  using Lines = std::vector<std::string>;
  EXPECT_EQ(LinesOf(""), Lines{});
  EXPECT_EQ(LinesOf("a\n\nb\n"), (Lines{"a", "", "b"}));
  EXPECT_EQ(LinesOf("a\nb"), (Lines{"a", "b"})) << "the last one needs no end";
  const std::string nul("x\0y", 3);
  EXPECT_EQ(LinesOf(nul + "\n"), Lines{nul});
}

TEST(LineReaderTest, ALineWithoutAnEndTakesNoMemoryWithoutOne) {
  const std::string text(5 * LineReader::kMaxLineBytes, 'a');
  size_t bytes = 0;
  for (const std::string& line : LinesOf(text)) {
    EXPECT_LE(line.size(), 2 * LineReader::kMaxLineBytes);
    bytes += line.size();
  }
  EXPECT_EQ(bytes, text.size());
}

TEST(LineReaderTest, AStopEndsTheWait) {
  const TemporaryFolder folder;
  const std::string path = folder / "pipe";
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  const int pipe = open(path.c_str(), O_RDWR | O_CLOEXEC);
  const auto reader = LineReader::Open(path).value();
  ASSERT_EQ(write(pipe, "one\ntw", 6), 6);
  EXPECT_EQ(reader->Next({}), "one");
  std::stop_source source;
  auto next = std::async(std::launch::async, [&] { return reader->Next(source.get_token()); });
  EXPECT_EQ(next.wait_for(std::chrono::milliseconds(200)), std::future_status::timeout);
  source.request_stop();
  EXPECT_EQ(next.get(), std::nullopt);
  close(pipe);
}

TEST(LineReaderTest, AFileThatIsNotThereIsSaidSo) {
  const absl::Status none = LineReader::Open("/nowhere/at/all").status();
  EXPECT_EQ(ErrorFieldPath(none), "--script");
  EXPECT_EQ(ErrorReason(none), "CANNOT_READ");
  EXPECT_FALSE(LineReader::Open("/tmp").ok()) << "a folder is no script";
}

}  // namespace
}  // namespace penumbra::testing
