// Runs the real program, and a folder of the test's own to run it in.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "server/penumbra_server.h"

namespace penumbra::testing {

struct Finished {
  int exit_status = -1;
  std::string out;
  std::string err;
};

inline std::string ReadText(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// One box, 2 m wide, from 1 m to 3 m above the ground, and a flat wall.
inline constexpr char kSceneObj[] = R"(o box
v -1 1 -1
v 1 1 -1
v 1 1 1
v -1 1 1
v -1 3 -1
v 1 3 -1
v 1 3 1
v -1 3 1
f 1 2 3 4
f 8 7 6 5
f 1 5 6 2
f 2 6 7 3
f 3 7 8 4
f 4 8 5 1
o wall
v -3 0 -3
v 3 0 -3
v 3 2 -3
v -3 2 -3
f 9 10 11 12
)";

class ProgramTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = std::filesystem::temp_directory_path() / "penumbra-cli-XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    std::ofstream(folder_ / "scene.obj") << kSceneObj;
    scene_ = (folder_ / "scene.obj").string();
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string StartServer() {
    auto server = PenumbraServer::Start({.listen = "127.0.0.1:0", .opens_gl = false});
    EXPECT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    return server_->address();
  }

  // Starts the program with its output in files of the folder named after `name`.
  pid_t Start(const std::vector<std::string>& arguments, const std::string& name) {
    const std::string out = folder_ / (name + ".out");
    const std::string err = folder_ / (name + ".err");
    std::vector<std::string> words = {PENUMBRA_PROGRAM};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    constexpr int kNew = O_WRONLY | O_CREAT | O_TRUNC;
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, out.c_str(), kNew, 0600);
    posix_spawn_file_actions_addopen(&files, STDERR_FILENO, err.c_str(), kNew, 0600);
    pid_t child = -1;
    EXPECT_EQ(posix_spawn(&child, argv[0], &files, nullptr, argv.data(), environ), 0);
    posix_spawn_file_actions_destroy(&files);
    return child;
  }

  Finished Wait(pid_t child, const std::string& name) {
    int status = 0;
    EXPECT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
    return {.exit_status = WIFEXITED(status) ? WEXITSTATUS(status) : -1,
            .out = ReadText(folder_ / (name + ".out")),
            .err = ReadText(folder_ / (name + ".err"))};
  }

  Finished Run(const std::vector<std::string>& arguments) {
    return Wait(Start(arguments, "run"), "run");
  }

  nlohmann::json ReadJson(const std::filesystem::path& path) {
    return nlohmann::json::parse(ReadText(path), nullptr, false);
  }

  std::filesystem::path folder_;
  std::string scene_;
  std::unique_ptr<PenumbraServer> server_;
};

}  // namespace penumbra::testing
