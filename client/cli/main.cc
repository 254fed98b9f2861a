// penumbra: the command line. Exit status 0: done; 1: it failed; 2: the command line makes no
// sense.
#include <unistd.h>

#include <iostream>
#include <string>
#include <vector>

#include "client/cli/command_line.h"
#include "client/cli/interrupt.h"
#include "client/cli/option_error.h"
#include "client/cli/run_command.h"

namespace {

int Fail(const absl::Status& status, int exit_status) {
  std::cerr << "penumbra: " << penumbra::OneLine(std::string(status.message())) << std::endl;
  return exit_status;
}

}  // namespace

int main(int argc, char** argv) {
  const penumbra::Interrupt interrupt;
  const auto command = penumbra::ParseCommandLine({argv + 1, argv + argc});
  if (!command.ok()) return Fail(command.status(), 2);
  const penumbra::Console console{
      .out = std::cout, .err = std::cerr, .err_is_terminal = isatty(STDERR_FILENO) != 0};
  const absl::Status status = penumbra::RunCommand(*command, console, interrupt.token());
  return status.ok() ? 0 : Fail(status, 1);
}
