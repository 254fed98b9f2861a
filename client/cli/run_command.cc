#include "client/cli/run_command.h"

#include <variant>

namespace penumbra {

absl::Status Run(const PrintText& command, const Console& console, std::stop_token) {
  console.out << command.text;
  return absl::OkStatus();
}

absl::Status RunCommand(const Command& command, const Console& console, std::stop_token stop) {
  absl::Status status =
      std::visit([&](const auto& chosen) { return Run(chosen, console, stop); }, command);
  console.out.flush();
  if (status.ok() && !console.out.good()) {
    status = absl::UnavailableError("standard output: cannot be written");
  }
  return status;
}

}  // namespace penumbra
