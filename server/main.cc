// penumbrad: computes shadows for clients on this machine.

#include <grpc/support/log.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include "google/protobuf/stubs/logging.h"
#include "server/address_file.h"
#include "server/keep_freed_memory.h"
#include "server/penumbra_server.h"
#include "server/security/token_command.h"
#include "server/server_identity.h"

namespace penumbra {
namespace {

struct CommandLine {
  ServerOptions server;
  int drain_seconds = 5;
  std::string address_file;
  TokenRequest token;
};

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

void TellOfProblem(const std::string& problem) {
  std::fprintf(stderr, "penumbrad: %s\n", problem.c_str());
}

int Serve(CommandLine command) {
  AllowManyConnections();
  command.server.security.on_problem = TellOfProblem;
  const sigset_t signals = BlockEndingSignals();
  AddressFile address_file(command.address_file);
  address_file.RemoveIfDead();
  auto server = PenumbraServer::Start(command.server);
  if (!server.ok()) return Fail(std::string(server.status().message()));
  if (const auto status = address_file.Write((*server)->address()); !status.ok()) {
    return Fail(std::string(status.message()));
  }
  std::fprintf(stderr, "penumbrad: %sGL: %s\n", (*server)->is_degraded() ? "degraded, " : "",
               (*server)->gl_summary().c_str());
  std::printf("listening on %s\n", (*server)->address().c_str());
  std::fflush(stdout);

  const int first = WaitFor(signals);
  std::fprintf(stderr, "penumbrad: %s, draining for at most %d s\n", strsignal(first),
               command.drain_seconds);
  std::thread([signals] { _exit(128 + WaitFor(signals)); }).detach();
  address_file.Remove();  // while the address is still this server's
  (*server)->Shutdown(std::chrono::seconds(command.drain_seconds));
  return EXIT_SUCCESS;
}

void AddOptions(CLI::App& app, CommandLine& command) {
  app.add_option("--listen", command.server.listen,
                 "Address: loopback, with TLS any; port 0 for a free one; or unix:PATH")
      ->capture_default_str();
  AddSecurityOptions(app, command.server.security);
  AddTokenCommand(app, command.token);
  app.add_option("--threads", command.server.threads, "Threads that compute; 0: all cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.add_option("--runners", command.server.runners,
                 "Artifacts that are computed at a time, besides one final picture")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--egl-device", command.server.egl_device,
                 "EGL device, by number or part of its name; default: the first hardware device, "
                 "else software");
  app.add_flag("--reflection", command.server.reflection,
               "Let clients ask for the service's description");
  app.add_option("--drain-seconds", command.drain_seconds,
                 "How long calls may take to end after SIGTERM; a second SIGTERM ends at once")
      ->check(CLI::Range(0, 3600))
      ->capture_default_str();
  app.add_option(
      "--address-file", command.address_file,
      "Write the address to this file once the server listens; removed when it stops listening");
  app.set_version_flag("--version", kServerName);
}

}  // namespace
}  // namespace penumbra

int main(int argc, char** argv) {
  penumbra::KeepFreedMemory();
  penumbra::SilenceLibraries();
  CLI::App app{"Penumbra server: computes soft shadows for the scenes that clients stream to it."};
  penumbra::CommandLine command;
  penumbra::AddOptions(app, command);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp& help) {
    return app.exit(help);
  } catch (const CLI::CallForVersion& version) {
    return app.exit(version);
  } catch (const CLI::Success&) {
    return EXIT_SUCCESS;  // of a command that is done
  } catch (const CLI::ParseError& error) {
    return penumbra::Fail(error.what());
  }
  return penumbra::Serve(command);
}
