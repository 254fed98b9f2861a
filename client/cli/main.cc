// penumbra: the command line. Exit status 0: done; 1: it failed, or scenes differ; 2: the command
// line by itself makes no sense, or scenes could not be compared.
#include <unistd.h>

#include <exception>
#include <iostream>
#include <string>
#include <variant>
#include <vector>

#include "client/cli/command_line.h"
#include "client/cli/interrupt.h"
#include "client/cli/option_error.h"
#include "client/cli/run_command.h"
#include "render/scene/field_error.h"

namespace {

int Fail(const absl::Status& status, int exit_status) {
  std::cerr << "penumbra: " << penumbra::OneLine(std::string(status.message())) << std::endl;
  return exit_status;
}

int RunProgram(const std::vector<std::string>& arguments) {
  const penumbra::Interrupt interrupt;
  const auto command = penumbra::ParseCommandLine(arguments);
  if (!command.ok()) return Fail(command.status(), 2);
  const penumbra::Console console{.out = std::cout,
                                  .err = std::cerr,
                                  .err_is_terminal = isatty(STDERR_FILENO) != 0,
                                  .out_is_terminal = isatty(STDOUT_FILENO) != 0};
  const absl::Status status = penumbra::RunCommand(*command, console, interrupt.token());
  if (status.ok()) return 0;
  if (penumbra::ErrorReason(status) == penumbra::kScenesDiffer) return 1;
  // As diff does, for which 1 means a difference.
  if (std::holds_alternative<penumbra::ScenesDiffCommand>(*command)) return Fail(status, 2);
  // Options that contradict each other, or the technique.
  const bool is_of_an_option = status.code() == absl::StatusCode::kInvalidArgument &&
                               penumbra::ErrorFieldPath(status).starts_with("--");
  return Fail(status, is_of_an_option ? 2 : 1);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return RunProgram({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    // No memory left, in all likelihood: nothing of ours throws.
    return Fail(absl::ResourceExhaustedError(error.what()), 1);
  }
}
