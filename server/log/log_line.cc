#include "server/log/log_line.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "absl/strings/ascii.h"
#include "absl/time/time.h"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kCutMark = "…";

bool ContinuesCharacter(char byte) { return (static_cast<unsigned char>(byte) & 0xc0) == 0x80; }

std::string TimeText(std::chrono::system_clock::time_point time) {
  return absl::FormatTime("%Y-%m-%dT%H:%M:%E3SZ", absl::FromChrono(time), absl::UTCTimeZone());
}

Json ToJson(const LogField::Value& value, size_t max_text_bytes) {
  return std::visit(
      [&](const auto& held) -> Json {
        if constexpr (std::same_as<std::decay_t<decltype(held)>, std::string_view>) {
          return CutText(held, max_text_bytes);
        } else {
          return held;
        }
      },
      value);
}

// Bytes that are no UTF-8 become U+FFFD.
std::string Dump(const Json& value) {
  return value.dump(-1, ' ', /*ensure_ascii=*/true, Json::error_handler_t::replace);
}

bool IsPlainWord(std::string_view text) {
  constexpr std::string_view kOthers = "._-+:/@%,[]()";
  return !text.empty() && std::ranges::all_of(text, [&](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || kOthers.find(c) != kOthers.npos;
  });
}

std::string TextValue(const Json& value) {
  const bool is_bare = value.is_string() && IsPlainWord(value.get_ref<const std::string&>());
  return is_bare ? value.get<std::string>() : Dump(value);
}

}  // namespace

std::string_view NameOf(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return "debug";
    case LogLevel::kInfo:
      return "info";
    case LogLevel::kWarning:
      return "warning";
    case LogLevel::kError:
      return "error";
  }
  return "";
}

std::string CutText(std::string_view text, size_t max_bytes) {
  if (text.size() <= max_bytes) return std::string(text);
  size_t end = max_bytes - kCutMark.size();
  // At most three steps: what goes on for longer is no UTF-8.
  for (int step = 0; step < 3 && end > 0 && ContinuesCharacter(text[end]); ++step) --end;
  return std::string(text.substr(0, end)).append(kCutMark);
}

std::string LogLine(LogFormat format, std::chrono::system_clock::time_point time, LogLevel level,
                    std::string_view event, std::span<const LogField> fields,
                    size_t max_text_bytes) {
  if (format == LogFormat::kText) {
    std::string line = TimeText(time);
    line.append(" ").append(NameOf(level)).append(" ").append(event);
    for (const LogField& field : fields) {
      const Json value = ToJson(field.value, max_text_bytes);
      line.append(" ").append(field.name).append("=").append(TextValue(value));
    }
    return line + "\n";
  }
  Json json = {{"time", TimeText(time)}, {"level", NameOf(level)}, {"event", event}};
  for (const LogField& field : fields) {
    json[std::string(field.name)] = ToJson(field.value, max_text_bytes);
  }
  return Dump(json) + "\n";
}

}  // namespace penumbra
