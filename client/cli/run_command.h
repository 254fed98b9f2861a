// Acts on what was asked for.
//
//   absl::Status status = RunCommand(*command, console, interrupt.token());
#pragma once

#include <stop_token>

#include "absl/status/status.h"
#include "client/cli/commands.h"
#include "client/cli/console.h"

namespace penumbra {

// The reason of the error that is none: a comparison found a difference, and has said so.
inline constexpr char kScenesDiffer[] = "SCENES_DIFFER";

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
absl::Status Run(const ScenesListCommand& command, const Console& console, std::stop_token stop);
absl::Status Run(const ScenesExportCommand& command, const Console& console, std::stop_token stop);
absl::Status Run(const ScenesImportCommand& command, const Console& console, std::stop_token stop);
absl::Status Run(const ScenesDeleteCommand& command, const Console& console, std::stop_token stop);
absl::Status Run(const ScenesDiffCommand& command, const Console& console, std::stop_token stop);
absl::Status Run(const ReplayCommand& command, const Console& console, std::stop_token stop);
absl::Status Run(const WhoCommand& command, const Console& console, std::stop_token stop);
absl::Status Run(const EditCommand& command, const Console& console, std::stop_token stop);
absl::Status Run(const EditControlCommand& command, const Console& console, std::stop_token stop);

}  // namespace penumbra
