// The program penumbrad, started by a test.
//
//   Daemon daemon({"--listen", "127.0.0.1:0"});
//   WireClient client(daemon.Address());
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

namespace penumbra::testing {

// The program with its output in pipes.
class Daemon {
 public:
  // It writes to no folder that a test has not named: what the user has there is no test's.
  explicit Daemon(std::vector<std::string> arguments, bool keeps_scenes_by_default = false) {
    const bool names_one = std::count(arguments.begin(), arguments.end(), "--data-dir") > 0;
    if (!names_one && !keeps_scenes_by_default) {
      arguments.insert(arguments.begin(), "--ephemeral");
    }
    int out[2], err[2];
    if (pipe2(out, O_CLOEXEC) != 0 || pipe2(err, O_CLOEXEC) != 0) std::abort();
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
  // Empty: it does not say where it listens, but something else.
  std::string Address() {
    const std::string line = OutputLine();
    const std::string prefix = "listening on ";
    return line.starts_with(prefix) ? line.substr(prefix.size()) : std::string();
  }
  pid_t pid() const { return pid_; }
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
