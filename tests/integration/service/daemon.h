// The program penumbrad, started by a test.
//
//   Daemon daemon({"--listen", "127.0.0.1:0"});
//   WireClient client(daemon.Address());
#pragma once

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <string>
#include <vector>

namespace penumbra::testing {

// The program with its output in pipes.
class Daemon {
 public:
  explicit Daemon(std::vector<std::string> arguments) {
    int out[2], err[2];
    EXPECT_EQ(pipe2(out, O_CLOEXEC), 0);
    EXPECT_EQ(pipe2(err, O_CLOEXEC), 0);
    arguments.insert(arguments.begin(), PENUMBRAD);
    std::vector<char*> argv;
    for (auto& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ == 0) {
      dup2(out[1], STDOUT_FILENO);
      dup2(err[1], STDERR_FILENO);
      execv(argv[0], argv.data());
      _exit(127);
    }
    close(out[1]);
    close(err[1]);
    out_ = out[0];
    err_ = err[0];
  }
  ~Daemon() {
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      Wait();
    }
    close(out_);
    close(err_);
  }

  // The first line that it writes, without the end.
  std::string OutputLine() { return ReadLine(out_); }
  std::string ErrorLine() { return ReadLine(err_); }
  std::string Address() {
    const std::string line = OutputLine();
    const std::string prefix = "listening on ";
    EXPECT_THAT(line, ::testing::StartsWith(prefix));
    return line.size() > prefix.size() ? line.substr(prefix.size()) : std::string();
  }
  void Signal(int number) { kill(pid_, number); }
  // Its exit status; −signal where a signal ended it.
  int Wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  static std::string ReadLine(int fd) {
    std::string line;
    char c;
    while (read(fd, &c, 1) == 1 && c != '\n') line += c;
    return line;
  }

  pid_t pid_ = -1;
  int out_ = -1;
  int err_ = -1;
};

}  // namespace penumbra::testing
