// Acts on what was asked for.
//
//   absl::Status status = RunCommand(*command, console, interrupt.token());
#pragma once

#include <stop_token>

#include "absl/status/status.h"
#include "client/cli/commands.h"
#include "client/cli/console.h"

namespace penumbra {

absl::Status RunCommand(const Command& command, const Console& console, std::stop_token stop);

absl::Status Run(const PrintText& command, const Console& console, std::stop_token stop);
absl::Status Run(const BakeCommand& command, const Console& console, std::stop_token stop);
absl::Status Run(const ViewCommand& command, const Console& console, std::stop_token stop);
absl::Status Run(const PushCommand& command, const Console& console, std::stop_token stop);
absl::Status Run(const WatchCommand& command, const Console& console, std::stop_token stop);
absl::Status Run(const TechniquesCommand& command, const Console& console, std::stop_token stop);
absl::Status Run(const InfoCommand& command, const Console& console, std::stop_token stop);
absl::Status Run(const TopCommand& command, const Console& console, std::stop_token stop);
absl::Status Run(const DemoCommand& command, const Console& console, std::stop_token stop);
absl::Status Run(const ReceiversCommand& command, const Console& console, std::stop_token stop);

}  // namespace penumbra
