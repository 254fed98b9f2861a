// Where the server says what happens: one event at a time, with named values.
//
//   logger.Info("session_opened", {{"session", number}, {"scene", scene_id}, {"client", name}});
//
// An event's name is a constant of the program, and so are the names of its fields; values may come
// from anyone. Tokens, keys and whole messages are never among them. Time, level and escaping are
// the logger's. Handed around, never global; render/ has none.
#pragma once

#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <variant>

namespace penumbra {

enum class LogLevel { kDebug, kInfo, kWarning, kError };

struct LogField {
  using Value = std::variant<std::string_view, int64_t, uint64_t, double, bool>;

  LogField(std::string_view field, std::string_view text) : name(field), value(text) {}
  LogField(std::string_view field, const char* text) : LogField(field, std::string_view(text)) {}
  LogField(std::string_view field, const std::string& text)
      : LogField(field, std::string_view(text)) {}
  LogField(std::string_view field, std::same_as<bool> auto is_so) : name(field), value(is_so) {}
  LogField(std::string_view field, std::floating_point auto number)
      : name(field), value(double{number}) {}
  LogField(std::string_view field, std::signed_integral auto number)
      : name(field), value(int64_t{number}) {}
  LogField(std::string_view field,
           std::unsigned_integral auto number) requires(!std::same_as<decltype(number), bool>)
      : name(field), value(uint64_t{number}) {}

  std::string_view name;
  Value value;  // a text need live until the event is written only
};

class Logger {
 public:
  virtual ~Logger() = default;

  // From any thread. Does not wait for whoever reads the log.
  virtual void Write(LogLevel level, std::string_view event, std::span<const LogField> fields) = 0;

  using Fields = std::initializer_list<LogField>;
  void Debug(std::string_view event, Fields fields) { Write(LogLevel::kDebug, event, fields); }
  void Info(std::string_view event, Fields fields) { Write(LogLevel::kInfo, event, fields); }
  void Warning(std::string_view event, Fields fields) { Write(LogLevel::kWarning, event, fields); }
  void Error(std::string_view event, Fields fields) { Write(LogLevel::kError, event, fields); }
};

// Drops everything.
Logger& QuietLogger();

}  // namespace penumbra
