// Reads the command line. The only place that knows the argument parser.
//
//   auto command = ParseCommandLine({argv + 1, argv + argc});
//   if (!command.ok()) …   // one line: "--size: found …", or "… Run with --help for more"
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cli/commands.h"

namespace penumbra {

// Errors  kInvalidArgument: what was typed makes no sense
absl::StatusOr<Command> ParseCommandLine(const std::vector<std::string>& arguments);

// `arguments` with the numbers that follow an option of numbers put into one argument, and tied to
// the option by '=', so that "--receiver -1 0 1 …" and "--receiver '-1,0,1 …'" read the same and no
// negative number is taken for an option.
std::vector<std::string> TieNumbersToOptions(const std::vector<std::string>& arguments);

}  // namespace penumbra
