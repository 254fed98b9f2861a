// penumbrad: computes shadows for clients on this machine.

#include <grpc/support/log.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>
#include <utility>

#include "absl/synchronization/mutex.h"
#include "google/protobuf/stubs/logging.h"
#include "server/address_file.h"
#include "server/data_folder.h"
#include "server/keep_freed_memory.h"
#include "server/log/line_logger.h"
#include "server/options.h"
#include "server/penumbra_server.h"

namespace penumbra {
namespace {

// Past the drain, for what computes to be stopped and put away; together with the usual drain of
// 5 s less than the 10 s that a service manager waits.
constexpr int kTeardownSeconds = 4;

// What the signals are that end the server; all threads leave them to sigwait.
sigset_t BlockEndingSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  signal(SIGPIPE, SIG_IGN);
  signal(SIGHUP, SIG_IGN);
  return signals;
}

int WaitFor(const sigset_t& signals) {
  int number = 0;
  sigwait(&signals, &number);
  return number;
}

// gRPC reports a failed bind on stderr in lines of its own, where ours says it in one; protobuf
// reports each malformed message, which any client can send.
void SilenceLibraries() {
  if (!std::getenv("GRPC_VERBOSITY")) gpr_set_log_function([](gpr_log_func_args*) {});
  google::protobuf::SetLogHandler(nullptr);
}

// Debian's Abseil keeps a graph of the order in which its locks are taken, as a check; gRPC's locks
// are of these, and a tenth of a loaded server's time went into it.
void LeaveLocksUnchecked() { absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore); }

int Fail(const std::string& message) {
  std::fprintf(stderr, "penumbrad: %s\n", message.c_str());
  return EXIT_FAILURE;
}

// A connection takes a descriptor, and 1,024 are the default of most systems.
void AllowManyConnections() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

int FailToStart(Logger& logger, const absl::Status& status) {
  logger.Error("cannot_start", {{"error", std::string(status.message())}});
  return EXIT_FAILURE;
}

// Ends the process at a second signal, or when its end takes longer than stated.
void EndItAnyway(const sigset_t& signals, int seconds, Logger& logger) {
  std::thread([signals, seconds, &logger] {
    const timespec patience{.tv_sec = seconds, .tv_nsec = 0};
    int number = -1;
    do {
      number = sigtimedwait(&signals, nullptr, &patience);
    } while (number < 0 && errno == EINTR);
    if (number > 0) _exit(128 + number);
    logger.Error("overran", {{"seconds", seconds}});
    _exit(EXIT_FAILURE);
  }).detach();
}

// Settles where scenes are kept.
absl::Status PrepareData(CommandLine& command) {
  std::string& folder = command.server.data_dir;
  if (auto status = CheckDataFolder(folder, command.has_data_dir, command.ephemeral);
      !status.ok()) {
    return status;
  }
  if (command.ephemeral) folder.clear();
  // Any other has to lie in a folder that is there: its name may be a mistake.
  if (folder.empty() || folder != DefaultDataFolder(FromEnvironment)) return absl::OkStatus();
  return MakeFoldersAround(folder);
}

int Serve(CommandLine command) {
  AllowManyConnections();
  const sigset_t signals = BlockEndingSignals();
  // Never destroyed: a thread of ours may use it to the very end.
  static LineLogger& logger = *new LineLogger(
      {.format = *LogFormatOf(command.log_format), .least = *LogLevelOf(command.log_level)});
  command.server.logger = &logger;
  command.server.security.on_problem = [](const std::string& problem) {
    logger.Warning("security", {{"problem", problem}});
  };
  if (auto status = PrepareData(command); !status.ok()) return FailToStart(logger, status);
  AddressFile address_file(command.address_file);
  address_file.RemoveIfDead();
  auto server = PenumbraServer::Start(command.server);
  if (!server.ok()) return FailToStart(logger, server.status());
  if (const auto status = address_file.Write((*server)->address()); !status.ok()) {
    return FailToStart(logger, status);
  }
  std::printf("listening on %s\n", (*server)->address().c_str());
  std::fflush(stdout);

  const int first = WaitFor(signals);
  logger.Info("draining", {{"signal", strsignal(first)}, {"seconds", command.drain_seconds}});
  EndItAnyway(signals, command.drain_seconds + kTeardownSeconds, logger);
  address_file.Remove();  // while the address is still this server's
  (*server)->Shutdown(std::chrono::seconds(command.drain_seconds));
  server->reset();
  logger.Info("stopped", {});
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace penumbra

int main(int argc, char** argv) {
  penumbra::KeepFreedMemory();
  penumbra::SilenceLibraries();
  penumbra::LeaveLocksUnchecked();
  auto command = penumbra::ReadOptions({argv + 1, argv + argc}, penumbra::FromEnvironment);
  if (!command.ok()) return penumbra::Fail(std::string(command.status().message()));
  if (command->is_done) return EXIT_SUCCESS;
  if (command->text.empty()) return penumbra::Serve(*std::move(command));
  std::fputs(command->text.c_str(), stdout);
  return std::fflush(stdout) == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
