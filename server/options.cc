#include "server/options.h"

#include <CLI/CLI.hpp>
#include <utility>

#include "server/data_folder.h"
#include "server/quota/quota_options.h"
#include "server/security/security_options.h"
#include "server/security/token_command.h"
#include "server/server_identity.h"

namespace penumbra {
namespace {

constexpr char kSources[] =
    "Every option can also be given by the environment, --drain-seconds as PENUMBRA_DRAIN_SECONDS, "
    "and by the file of --config, as drain-seconds = 5. The command line goes before the "
    "environment, and that before the file.";

void AddServing(CLI::App& app, ServerOptions& server) {
  app.add_option("--listen", server.listen,
                 "Address: loopback, with TLS any; port 0 for a free one; or unix:PATH");
  app.add_option("--threads", server.threads, "Threads that compute; 0: all cores")
      ->check(CLI::Range(0, 1024));
  app.add_option("--runners", server.runners,
                 "Artifacts that are computed at a time, besides one final picture")
      ->check(CLI::Range(1, 64));
  app.add_option("--max-read-delay", server.limits.max_read_delay_ms,
                 "Milliseconds that requests may wait until they are read; while they wait longer "
                 "commits are refused; 0: none are")
      ->check(CLI::Range(0, 60'000));
  app.add_option("--egl-device", server.egl_device,
                 "EGL device, by number or part of its name; default: the first hardware device, "
                 "else software");
  app.add_flag("--require-gpu", server.require_gpu,
               "Do not start where there is a software device only");
  app.add_option("--gpu-memory", server.gpu_memory_bytes,
                 "Bytes of GPU memory to use at most, with K, M or G; default: three quarters of "
                 "the device's, 1G in software")
      ->transform(CLI::AsSizeValue(false));
  app.add_flag("--reflection", server.reflection, "Let clients ask for the service's description");
}

// Of what a studio looks at in a day: some hundred textures, and some thousand on disk.
constexpr ResultOptions kResults{.memory_bytes = size_t{128} << 20,
                                 .disk_bytes = uint64_t{1} << 30};

void AddData(CLI::App& app, CommandLine& command) {
  app.add_option("--data-dir", command.server.data_dir,
                 "Folder to keep scenes in, which are there again when the server starts anew");
  app.add_flag("--ephemeral", command.ephemeral,
               "Keep scenes in memory alone: they end with the server");
  app.add_option("--result-memory", command.server.results.memory_bytes,
                 "Bytes of final artifacts to keep in memory, for whoever asks for the same again, "
                 "with K, M or G; 0: none")
      ->transform(CLI::AsSizeValue(false));
  app.add_option("--result-disk", command.server.results.disk_bytes,
                 "The same on disk, where scenes are kept there")
      ->transform(CLI::AsSizeValue(false));
}

void AddOperations(CLI::App& app, CommandLine& command) {
  app.add_option("--log-format", command.log_format, "How the log on stderr is written")
      ->check(CLI::IsMember({"text", "json"}));
  app.add_option("--log-level", command.log_level, "The least that is logged")
      ->check(CLI::IsMember({"debug", "info", "warning", "error"}));
  app.add_option("--metrics-listen", command.server.metrics_listen,
                 "Serve metrics to Prometheus at this address of loopback, such as "
                 "127.0.0.1:9464; default: nowhere");
  app.add_option("--drain-seconds", command.drain_seconds,
                 "How long calls may take to end after SIGTERM; a second SIGTERM ends at once")
      ->check(CLI::Range(0, 3600));
  app.add_option(
      "--address-file", command.address_file,
      "Write the address to this file once the server listens; removed when it stops listening");
}

void AddOptions(CLI::App& app, CommandLine& command) {
  app.option_defaults()->always_capture_default();
  AddServing(app, command.server);
  AddData(app, command);
  AddSecurityOptions(app, command.server.security);
  AddQuotaOptions(app, command.server.quotas);
  AddOperations(app, command);
}

// What ends the program instead of telling it how to serve; not to be had from the other sources.
struct Ending {
  std::string config;
  bool prints_config = false;
  TokenRequest token;
};

void AddEnding(CLI::App& app, Ending& ending) {
  app.add_option("--config", ending.config, "Read options from this TOML file")
      ->configurable(false)
      ->type_name("FILE");
  app.add_flag("--print-config", ending.prints_config,
               "Print the options' values, in the form of that file, with where they come from")
      ->configurable(false);
  AddTokenCommand(app, ending.token);
  app.set_version_flag("--version", kServerName);
  app.footer(kSources);
}

absl::Status ReadSources(const Environment& environment, std::string config,
                         OptionSources& sources) {
  if (auto status = sources.ReadEnvironment(environment); !status.ok()) return status;
  if (config.empty()) config = environment(EnvironmentName("config"));
  return config.empty() ? absl::OkStatus() : sources.ReadFile(config);
}

// What a start finds wrong with the options by themselves, without a look at any file.
absl::Status CheckTogether(const ServerOptions& server) {
  if (auto status = CheckSecurity(server.security, server.listen); !status.ok()) return status;
  return ToOptions(server.quotas, /*everyone_is_known=*/true).status();
}

}  // namespace

absl::StatusOr<CommandLine> ReadOptions(const std::vector<std::string>& arguments,
                                        const Environment& environment) {
  CLI::App app{"Penumbra server: computes soft shadows for the scenes that clients stream to it.",
               "penumbrad"};
  CommandLine command;
  command.server.results = kResults;
  command.server.data_dir = DefaultDataFolder(environment);
  Ending ending;
  AddOptions(app, command);
  AddEnding(app, ending);
  try {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::CallForHelp&) {
    command.text = app.help();
    return command;
  } catch (const CLI::CallForVersion&) {
    command.text = std::string(kServerName) + "\n";
    return command;
  } catch (const CLI::Success&) {
    command.is_done = true;
    return command;
  } catch (const CLI::ParseError& error) {
    return absl::InvalidArgumentError(std::string("command line: ") + error.what());
  }
  OptionSources sources(app);
  if (auto status = ReadSources(environment, ending.config, sources); !status.ok()) return status;
  CLI::Option& data_dir = *app.get_option("--data-dir");
  command.has_data_dir = data_dir.count() > 0 && !command.server.data_dir.empty();
  // What is printed can be read again: both together are an error.
  if (command.ephemeral && !command.has_data_dir) data_dir.default_str("");
  if (!ending.prints_config) return command;
  if (auto status = CheckTogether(command.server); !status.ok()) return status;
  command.text = sources.Print();
  return command;
}

}  // namespace penumbra
