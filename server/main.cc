// penumbrad: computes shadows for clients on this machine.

#include <grpc/support/log.h>
#include <signal.h>
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
#include "server/server_identity.h"

namespace penumbra {
namespace {

struct CommandLine {
  ServerOptions server;
  int drain_seconds = 5;
  std::string address_file;
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

int Serve(const CommandLine& command) {
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
                 "Address: loopback, port 0 for a free one, or unix:PATH")
      ->capture_default_str();
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
  app.add_flag("--require-gpu", command.server.require_gpu,
               "Do not start where there is a software device only");
  app.add_option("--gpu-memory", command.server.gpu_memory_bytes,
                 "Bytes of GPU memory to use at most, with K, M or G; default: three quarters of "
                 "the device's, 1G in software")
      ->transform(CLI::AsSizeValue(false));
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
  } catch (const CLI::ParseError& error) {
    return penumbra::Fail(error.what());
  }
  return penumbra::Serve(command);
}
