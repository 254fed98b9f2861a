// That no value can break out of its line of the log (row E08), and that the log stays short.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "server/log/line_logger.h"
#include "server/log/log_line.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;
using std::chrono::milliseconds, std::chrono::system_clock;

constexpr system_clock::time_point kTime{std::chrono::seconds(1'795'745'893) + milliseconds(7)};

std::string JsonLine(const LogField& field) {
  const LogField fields[] = {field};
  return LogLine(LogFormat::kJson, kTime, LogLevel::kInfo, "session_opened", fields);
}

const std::vector<std::string>& HostileTexts() {
  static const std::vector<std::string> texts = {
      "two\r\nlines",
      "\"}\n{\"level\":\"error\",\"event\":\"forged\"}",
      "\x1b[2J\x1b]0;owned\x07",
      "\xc2\x9b"
      "31m of eight bits",
      "%s%n%x {} {0} ${HOME} $(reboot)",
      std::string("nul\0inside", 10),
      "\xff\xfe\xc0\x80 no UTF-8",
      "\xed\xa0\x80 a surrogate",
      "\xe2\x80\xae"
      "right to left",
      "\xe2\x80\xa8"
      "a separator",
      "\\ and \" and / and \x7f",
      std::string(1 << 20, 'A'),
      std::string(1 << 20, '\n'),
      std::string(100, '\xe2'),
  };
  return texts;
}

TEST(LogLineTest, E08HostileTextsStayInsideOneLineOfJson) {
  for (const std::string& text : HostileTexts()) {
    const std::string line = JsonLine({"client", text});
    EXPECT_EQ(line.find('\n'), line.size() - 1) << line;
    for (const char c : line.substr(0, line.size() - 1)) {
      EXPECT_TRUE(c >= 0x20 && c < 0x7f) << static_cast<int>(c) << " in " << line;
    }
    const Json json = Json::parse(line, nullptr, false);
    ASSERT_TRUE(json.is_object()) << line;
    EXPECT_EQ(json.size(), 4u) << "no field was added";
    EXPECT_EQ(json["level"], "info");
    EXPECT_LE(json["client"].get<std::string>().size(), 3 * kMaxLoggedBytes);
    EXPECT_LT(line.size(), 2'000u);
  }
}

TEST(LogLineTest, E08HostileTextsStayInsideOneLineForPeople) {
  for (const std::string& text : HostileTexts()) {
    const LogField fields[] = {{"client", text}, {"after", 1}};
    const std::string line =
        LogLine(LogFormat::kText, kTime, LogLevel::kInfo, "session_opened", fields);
    EXPECT_EQ(line.find('\n'), line.size() - 1) << line;
    for (const char c : line.substr(0, line.size() - 1)) EXPECT_TRUE(c >= 0x20 && c < 0x7f);
    EXPECT_TRUE(line.ends_with(" after=1\n")) << line;
  }
}

TEST(LogLineTest, SaysWhenWhatAndHow) {
  EXPECT_EQ(
      JsonLine({"port", 7717}),
      "{\"time\":\"2026-11-27T02:18:13.007Z\",\"level\":\"info\",\"event\":\"session_opened\","
      "\"port\":7717}\n");
  const LogField fields[] = {{"word", "plain"}, {"text", "with \"blanks\""}, {"yes", true},
                             {"less", -3},      {"more", uint64_t{1} << 63}, {"half", 0.5},
                             {"nothing", ""}};
  EXPECT_EQ(LogLine(LogFormat::kText, kTime, LogLevel::kWarning, "started", fields),
            "2026-11-27T02:18:13.007Z warning started word=plain text=\"with \\\"blanks\\\"\" "
            "yes=true less=-3 more=9223372036854775808 half=0.5 nothing=\"\"\n");
}

TEST(CutTextTest, CutsBetweenCharacters) {
  EXPECT_EQ(CutText(std::string(256, 'a'), 256), std::string(256, 'a'));
  EXPECT_EQ(CutText(std::string(257, 'a'), 256), std::string(253, 'a') + "…");
  std::string euros;
  for (int i = 0; i < 100; ++i) euros += "€";
  EXPECT_EQ(CutText(std::string("a").append(euros), 256),
            std::string("a").append(euros, 0, 84 * 3).append("…"));
  EXPECT_EQ(CutText(std::string("ab").append(euros), 256),
            std::string("ab").append(euros, 0, 83 * 3).append("…"));
  std::string clefs;
  for (int i = 0; i < 100; ++i) clefs += "\xf0\x9d\x84\x9e";
  EXPECT_EQ(CutText(clefs, 256), clefs.substr(0, 63 * 4) + "…");
}

// A logger whose lines a test reads, at times that it sets.
class LineLoggerTest : public ::testing::Test {
 protected:
  LineLoggerTest() {
    int ends[2];
    EXPECT_EQ(pipe2(ends, O_CLOEXEC | O_NONBLOCK), 0);
    read_end_ = ends[0];
    write_end_ = ends[1];
  }
  ~LineLoggerTest() override {
    close(read_end_);
    close(write_end_);
  }

  LineLogger::Options Options() {
    return {.format = LogFormat::kJson, .descriptor = write_end_, .now = [this] { return now_; }};
  }

  std::vector<Json> Lines() {
    std::string text(1 << 16, '\0');
    const ssize_t count = read(read_end_, text.data(), text.size());
    text.resize(count < 0 ? 0 : static_cast<size_t>(count));
    std::vector<Json> lines;
    for (size_t begin = 0; begin < text.size();) {
      const size_t end = text.find('\n', begin);
      lines.push_back(Json::parse(text.substr(begin, end - begin), nullptr, false));
      EXPECT_TRUE(lines.back().is_object());
      begin = end + 1;
    }
    return lines;
  }

  system_clock::time_point now_ = kTime;
  int read_end_ = -1;
  int write_end_ = -1;
};

TEST_F(LineLoggerTest, LeavesOutWhatIsNotWanted) {
  auto options = Options();
  options.least = LogLevel::kWarning;
  LineLogger logger(options);
  logger.Debug("a", {});
  logger.Info("b", {});
  logger.Warning("c", {});
  logger.Error("d", {});
  const auto lines = Lines();
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0]["event"], "c");
  EXPECT_EQ(lines[1]["event"], "d");
}

TEST_F(LineLoggerTest, AFloodOfOneEventIsCountedAndHidesNoOther) {
  LineLogger logger(Options());
  for (int i = 0; i < 1'000; ++i) logger.Info("refused", {});
  logger.Info("started", {});
  auto lines = Lines();
  ASSERT_EQ(lines.size(), LineLogger::kMaxPerSecond + 1);
  EXPECT_EQ(lines.back()["event"], "started");
  now_ += milliseconds(1'001);
  logger.Info("refused", {});
  lines = Lines();
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0]["event"], "log_suppressed");
  EXPECT_EQ(lines[0]["of"], "refused");
  EXPECT_EQ(lines[0]["lines"], 1'000 - LineLogger::kMaxPerSecond);
  EXPECT_EQ(lines[1]["event"], "refused");
}

TEST_F(LineLoggerTest, TellsAtItsEndWhatWasLeftOut) {
  {
    LineLogger logger(Options());
    for (uint64_t i = 0; i < LineLogger::kMaxPerSecond + 5; ++i) logger.Info("refused", {});
  }
  EXPECT_EQ(Lines().back()["lines"], 5);
}

TEST_F(LineLoggerTest, AReaderThatDoesNotReadHoldsUpNobody) {
  fcntl(write_end_, F_SETPIPE_SZ, 8192);
  fcntl(write_end_, F_SETFL, fcntl(write_end_, F_GETFL) & ~O_NONBLOCK);
  LineLogger logger(Options());
  const std::string text(200, 'x');
  for (int i = 0; i < 100; ++i) {
    now_ += milliseconds(100);
    logger.Info("event", {{"text", text}});
  }
  const auto kept = Lines();
  EXPECT_GT(kept.size(), 5u);
  EXPECT_LT(kept.size(), 50u);
  now_ += milliseconds(100);
  logger.Info("event", {});
  const auto lines = Lines();
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0]["event"], "log_dropped");
  EXPECT_EQ(lines[0]["lines"].get<size_t>() + kept.size(), 100u);
}

TEST_F(LineLoggerTest, LinesStaySmallEnoughForAPipeToTakeThemWhole) {
  LineLogger logger(Options());
  const std::string text(1'000, '\x01');
  logger.Info("event", {{"a", text}, {"b", text}, {"c", text}, {"d", text}});
  const auto lines = Lines();
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0].size(), 7u);
}

TEST(LogNamesTest, ReadBack) {
  EXPECT_EQ(*LogFormatOf("json"), LogFormat::kJson);
  EXPECT_EQ(*LogLevelOf("warning"), LogLevel::kWarning);
  EXPECT_FALSE(LogFormatOf("xml").ok());
  EXPECT_FALSE(LogLevelOf("loud").ok());
}

}  // namespace
}  // namespace penumbra::testing
