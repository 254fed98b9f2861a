// penumbra top.
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "client/cli/open_engine.h"
#include "client/cli/run_command.h"
#include "client/cli/server_json.h"
#include "client/cli/status_table.h"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

constexpr char kClearScreen[] = "\x1b[H\x1b[2J";

// Whether the time has passed; not, if a stop was asked for.
bool Wait(double seconds, const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_for(lock, stop, std::chrono::duration<double>(seconds), [] { return false; });
  return !stop.stop_requested();
}

}  // namespace

absl::Status Run(const TopCommand& command, const Console& console, std::stop_token stop) {
  const auto engine = ConnectTo(command.engine);
  if (!engine.ok()) return engine.status();
  std::optional<Json> before;
  do {
    const auto now = AskServer(**engine, &RemoteEngine::ServerStatusJson);
    if (!now.ok()) return now.status();
    if (command.json) {
      console.out << now->dump() << std::endl;
      if (command.once) break;
      continue;
    }
    // One table has rates too, so it takes two looks.
    if (!command.once || before) {
      if (console.out_is_terminal && !command.once) console.out << kClearScreen;
      console.out << StatusTable(command.engine.server, before ? &*before : nullptr, *now,
                                 command.rows);
      if (!console.out_is_terminal && !command.once) console.out << '\n';
      console.out.flush();
      if (command.once) break;
    }
    before = *now;
  } while (console.out.good() && Wait(command.interval_s, stop));
  return absl::OkStatus();
}

}  // namespace penumbra
