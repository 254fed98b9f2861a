// What penumbrad is told: by its command line, its environment and a file.
//
//   const auto command = ReadOptions({argv + 1, argv + argc}, FromEnvironment);
//   if (!command->text.empty()) …print it and end
//
// A new option is a member of CommandLine, or of what it holds, and a line of AddOptions in
// options.cc: the other sources, --print-config and their errors follow (option_sources.h).
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/log/line_logger.h"
#include "server/option_sources.h"
#include "server/penumbra_server.h"

namespace penumbra {

struct CommandLine {
  ServerOptions server;       // data_dir: also where nobody said one, see data_folder.h
  bool has_data_dir = false;  // somebody did
  bool ephemeral = false;
  std::string log_format = "text";  // see LogFormatOf
  std::string log_level = "info";   // see LogLevelOf
  int drain_seconds = 5;
  std::string address_file;
  // To be printed instead of serving: help, the version, or the options' values.
  std::string text;
  // Everything is done: a token was made.
  bool is_done = false;
};

// Precedence: the command line, the environment, the file of --config, the default. Options are not
// related to one another here (by CLI11's needs() and the like), since their values may come from
// different places; whoever uses them checks that they go together.
//
// Errors  kInvalidArgument: the option and where its value came from; where the values are to be
//         printed, also those of CheckSecurity and of ToOptions for quotas
absl::StatusOr<CommandLine> ReadOptions(const std::vector<std::string>& arguments,
                                        const Environment& environment);

}  // namespace penumbra
