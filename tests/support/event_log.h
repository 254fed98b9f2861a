// A log that tests read: a line for each event, as "name field=value field=value".
#pragma once

#include <mutex>
#include <sstream>
#include <string>
#include <variant>

#include "server/log/logger.h"

namespace penumbra::testing {

class EventLog : public Logger {
 public:
  void Write(LogLevel, std::string_view event, std::span<const LogField> fields) override {
    std::ostringstream line;
    line << event;
    for (const LogField& field : fields) {
      line << " " << field.name << "=";
      std::visit([&](const auto& value) { line << value; }, field.value);
    }
    std::lock_guard lock(mutex_);
    text_ += line.str() + "\n";
  }
  std::string text() const {
    std::lock_guard lock(mutex_);
    return text_;
  }

 private:
  mutable std::mutex mutex_;
  std::string text_;
};

}  // namespace penumbra::testing
