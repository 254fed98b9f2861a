// A server with a scene that people are in, who are programs of their own.
#pragma once

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "client/session/remote_engine.h"
#include "tests/integration/cli/run_program.h"

namespace penumbra::testing {

using Json = nlohmann::json;
using Words = std::vector<std::string>;

inline std::vector<Json> JsonLines(const std::string& text) {
  std::vector<Json> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    lines.push_back(Json::parse(line, nullptr, false));
  }
  return lines;
}

class PeopleTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    address_ = StartServer();
    ASSERT_EQ(Run({"push", scene_, "--server", address_, "--scene", "studio", "--floor", "--size",
                   "16", "--rect-light", "-1 6 -1 2 0 0 0 0 2 5"})
                  .exit_status,
              0);
  }
  void TearDown() override {
    for (const auto& [child, pipe] : visitors_) {
      kill(child, SIGKILL);
      waitpid(child, nullptr, 0);
      close(pipe);
    }
    ProgramTest::TearDown();
  }

  Words At(Words words) {
    words.insert(words.begin() + 1, {"--server", address_, "--scene", "studio"});
    return words;
  }
  Finished RunAt(Words words) { return Run(At(std::move(words))); }
  std::shared_ptr<const Scene> Studio() {
    const auto engine = RemoteEngine::Connect({.address = address_}).value();
    return engine->Snapshot("studio").value();
  }
  bool WaitForOutput(const std::string& name, const std::string& text, const char* kind = ".out") {
    for (int i = 0; i < 600; ++i) {
      if (ReadText(folder_ / (name + kind)).find(text) != std::string::npos) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    ADD_FAILURE() << "no " << text << " in: " << ReadText(folder_ / (name + kind));
    return false;
  }

  // Somebody who edits by a pipe, and stays.
  struct Visitor {
    pid_t child = -1;
    int pipe = -1;
  };
  Visitor Visit(const std::string& name) {
    const std::string path = folder_ / (name + ".fifo");
    EXPECT_EQ(mkfifo(path.c_str(), 0600), 0);
    const int pipe = open(path.c_str(), O_RDWR | O_CLOEXEC);
    const pid_t child = Start(At({"edit", "--name", name, "--script", path, "--keep-going"}), name);
    visitors_.emplace_back(child, pipe);
    return {child, pipe};
  }
  // Whether the answer has `text`.
  bool Say(const std::string& name, const Visitor& visitor, const std::string& line,
           const std::string& text) {
    EXPECT_EQ(write(visitor.pipe, (line + "\n").data(), line.size() + 1),
              static_cast<ssize_t>(line.size() + 1));
    return WaitForOutput(name, text);
  }
  void Kill(const Visitor& visitor) {
    ASSERT_EQ(kill(visitor.child, SIGKILL), 0);
    waitpid(visitor.child, nullptr, 0);
    std::erase(visitors_, std::pair(visitor.child, visitor.pipe));
    close(visitor.pipe);
  }

  std::string address_;
  std::vector<std::pair<pid_t, int>> visitors_;
};

}  // namespace penumbra::testing
