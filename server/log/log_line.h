// An event as one line of ASCII, with its end.
//
//   {"time":"2026-11-27T02:18:13.123Z","level":"info","event":"started","port":7717}
//   2026-11-27T02:18:13.123Z info started port=7717
//
// Whatever is not a printable ASCII character is escaped as JSON does it, so that no value can end
// the line, move a terminal's cursor or change the direction of text. A text of more than
// kMaxLoggedBytes is cut, between characters of UTF-8, and ends in "…".
#pragma once

#include <chrono>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "server/log/logger.h"

namespace penumbra {

enum class LogFormat { kText, kJson };

inline constexpr size_t kMaxLoggedBytes = 256;

// The beginning of `text`, of at most `max_bytes` (three at least) with the "…" that marks a cut.
std::string CutText(std::string_view text, size_t max_bytes);

std::string LogLine(LogFormat format, std::chrono::system_clock::time_point time, LogLevel level,
                    std::string_view event, std::span<const LogField> fields,
                    size_t max_text_bytes = kMaxLoggedBytes);

// "warning", for instance.
std::string_view NameOf(LogLevel level);

}  // namespace penumbra
