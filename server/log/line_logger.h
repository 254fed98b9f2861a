// Writes events to a file descriptor, stderr by default, a line each.
//
//   LineLogger logger({.format = LogFormat::kJson, .least = LogLevel::kInfo});
//
// Nothing that clients do makes it long: of one kind of event at most kMaxPerSecond lines a second
// are written, and what is left out is counted in a line of its own ("log_suppressed"). Nor does it
// wait for a reader: a line that a full pipe has no room for is left out and counted
// ("log_dropped").
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <mutex>
#include <string>

#include "absl/status/statusor.h"
#include "server/log/log_line.h"
#include "server/log/logger.h"

namespace penumbra {

class LineLogger final : public Logger {
 public:
  using Clock = std::function<std::chrono::system_clock::time_point()>;

  static constexpr uint64_t kMaxPerSecond = 20;

  struct Options {
    LogFormat format = LogFormat::kText;
    LogLevel least = LogLevel::kInfo;
    int descriptor = 2;
    Clock now = std::chrono::system_clock::now;
  };

  explicit LineLogger(Options options);
  // Says what was left out.
  ~LineLogger() override;

  void Write(LogLevel level, std::string_view event, std::span<const LogField> fields) override;

 private:
  // Of one kind of event, in the second that began at `start`.
  struct Second {
    std::chrono::system_clock::time_point start{};
    uint64_t written = 0;
    uint64_t left_out = 0;
  };
  using Time = std::chrono::system_clock::time_point;

  // With the lock held, as for all below.
  bool MayWrite(std::string_view event, Time now);
  void TellLeftOut(Time now, bool all);
  void WriteLine(LogLevel level, std::string_view event, std::span<const LogField> fields,
                 Time now);
  bool Put(const std::string& line);

  const Options options_;
  std::mutex mutex_;
  std::map<std::string, Second, std::less<>> seconds_;  // by event
  uint64_t dropped_ = 0;
};

// "text" or "json". Errors  kInvalidArgument
absl::StatusOr<LogFormat> LogFormatOf(std::string_view name);
// "debug", "info", "warning" or "error". Errors  kInvalidArgument
absl::StatusOr<LogLevel> LogLevelOf(std::string_view name);

}  // namespace penumbra
