// A log that a test reads.
//
//   KeptLog log;                                         // outlives the server
//   options.logger = &log;
//   EXPECT_EQ(log.Await("session_opened", 1)[0]["scene"], "studio");
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "server/log/log_line.h"
#include "tests/integration/service/wire_client.h"

namespace penumbra::testing {

// Keeps events as the JSON of their lines.
class KeptLog final : public Logger {
 public:
  void Write(LogLevel level, std::string_view event, std::span<const LogField> fields) override {
    std::lock_guard lock(mutex_);
    events_.push_back(nlohmann::json::parse(
        LogLine(LogFormat::kJson, std::chrono::system_clock::now(), level, event, fields)));
  }

  // All of this kind, once there are `count`.
  std::vector<nlohmann::json> Await(const std::string& event, size_t count) {
    for (const auto end = std::chrono::steady_clock::now() + kPatience;
         std::chrono::steady_clock::now() < end;) {
      auto found = All(event);
      if (found.size() >= count) return found;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ADD_FAILURE() << "no " << count << " of " << event;
    return std::vector<nlohmann::json>(count, nlohmann::json::object());
  }

  std::vector<nlohmann::json> All(const std::string& event) {
    std::lock_guard lock(mutex_);
    std::vector<nlohmann::json> found;
    for (const nlohmann::json& json : events_) {
      if (event.empty() || json["event"] == event) found.push_back(json);
    }
    return found;
  }

 private:
  std::mutex mutex_;
  std::vector<nlohmann::json> events_;
};

}  // namespace penumbra::testing
