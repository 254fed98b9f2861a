#include "server/log/line_logger.h"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <utility>

#include "absl/strings/str_cat.h"

namespace penumbra {
namespace {

// A pipe that is ready takes so much at once, in one piece.
constexpr size_t kMaxLineBytes = PIPE_BUF;
// Of each text where whole ones would make the line longer than that.
constexpr size_t kShortTextBytes = 48;

class SilentLogger final : public Logger {
 public:
  void Write(LogLevel, std::string_view, std::span<const LogField>) override {}
};

}  // namespace

Logger& QuietLogger() {
  static SilentLogger logger;
  return logger;
}

LineLogger::LineLogger(Options options) : options_(std::move(options)) {}

LineLogger::~LineLogger() {
  std::lock_guard lock(mutex_);
  TellLeftOut(options_.now(), /*all=*/true);
}

void LineLogger::Write(LogLevel level, std::string_view event, std::span<const LogField> fields) {
  if (level < options_.least) return;
  const Time now = options_.now();
  std::lock_guard lock(mutex_);
  TellLeftOut(now, /*all=*/false);
  if (MayWrite(event, now)) WriteLine(level, event, fields, now);
}

bool LineLogger::MayWrite(std::string_view event, Time now) {
  auto found = seconds_.find(event);
  if (found == seconds_.end()) found = seconds_.emplace(std::string(event), Second{}).first;
  Second& second = found->second;
  // Also when the clock was set back.
  if (now < second.start || now >= second.start + std::chrono::seconds(1)) second = {.start = now};
  if (second.written < kMaxPerSecond) {
    ++second.written;
    return true;
  }
  ++second.left_out;
  return false;
}

void LineLogger::TellLeftOut(Time now, bool all) {
  for (auto& [event, second] : seconds_) {
    const bool is_over = now < second.start || now >= second.start + std::chrono::seconds(1);
    if (second.left_out == 0 || !(is_over || all)) continue;
    const LogField fields[] = {{"of", event}, {"lines", std::exchange(second.left_out, 0)}};
    WriteLine(LogLevel::kWarning, "log_suppressed", fields, now);
  }
  if (dropped_ == 0) return;
  const LogField fields[] = {{"lines", dropped_}};
  const uint64_t before = std::exchange(dropped_, 0);
  WriteLine(LogLevel::kWarning, "log_dropped", fields, now);
  if (dropped_ > 0) dropped_ = before;  // this line found no room either
}

void LineLogger::WriteLine(LogLevel level, std::string_view event, std::span<const LogField> fields,
                           Time now) {
  std::string line = LogLine(options_.format, now, level, event, fields);
  if (line.size() > kMaxLineBytes) {
    line = LogLine(options_.format, now, level, event, fields, kShortTextBytes);
  }
  if (!Put(line)) ++dropped_;
}

bool LineLogger::Put(const std::string& line) {
  pollfd ready{.fd = options_.descriptor, .events = POLLOUT, .revents = 0};
  if (::poll(&ready, 1, 0) != 1 || !(ready.revents & POLLOUT)) return false;
  size_t done = 0;
  while (done < line.size()) {
    const ssize_t count = ::write(options_.descriptor, line.data() + done, line.size() - done);
    if (count < 0 && errno != EINTR) return false;
    if (count > 0) done += static_cast<size_t>(count);
  }
  return true;
}

absl::StatusOr<LogFormat> LogFormatOf(std::string_view name) {
  if (name == "text") return LogFormat::kText;
  if (name == "json") return LogFormat::kJson;
  return absl::InvalidArgumentError(
      absl::StrCat("found '", std::string(name), "', need text or json"));
}

absl::StatusOr<LogLevel> LogLevelOf(std::string_view name) {
  for (const LogLevel level :
       {LogLevel::kDebug, LogLevel::kInfo, LogLevel::kWarning, LogLevel::kError}) {
    if (name == NameOf(level)) return level;
  }
  return absl::InvalidArgumentError(
      absl::StrCat("found '", std::string(name), "', need debug, info, warning or error"));
}

}  // namespace penumbra
