// penumbra who: the people in a server's scene.
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/cli/open_engine.h"
#include "client/cli/people.h"
#include "client/cli/run_command.h"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

constexpr char kClearScreen[] = "\x1b[H\x1b[2J";

std::string OneLineJson(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json LeftJson(const std::vector<Participant>& left) {
  Json people = Json::array();
  for (const Participant& other : left) {
    people.push_back({{"id", other.id}, {"name", other.presence.display_name}});
  }
  return people;
}

// Prints what changes, on the session's threads, and waits until that is over.
class WhoPrinter {
 public:
  WhoPrinter(const WhoCommand& command, const Console& console)
      : command_(command), console_(console) {}

  void Print(const PresenceChange& change);
  absl::Status Wait(const std::stop_token& stop);

 private:
  const WhoCommand& command_;
  const Console& console_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  absl::Status ended_;
};

void WhoPrinter::Print(const PresenceChange& change) {
  std::lock_guard lock(mutex_);
  ended_ = change.ended;
  changed_.notify_all();
  if (command_.json) {
    Json json = WhoJson(command_.scene_id, change.now);
    json["joined"] = change.joined;
    json["changed"] = change.changed;
    json["left"] = LeftJson(change.left);
    console_.out << OneLineJson(json) << std::endl;
    return;
  }
  if (console_.out_is_terminal) {
    console_.out << kClearScreen;
  } else {
    for (const Participant& other : change.left) {
      console_.out << ShownName(other.presence.display_name) << " has left\n";
    }
  }
  console_.out << WhoTable(command_.scene_id, change.now, console_.out_is_terminal) << std::endl;
}

absl::Status WhoPrinter::Wait(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  const auto has_ended = [this] { return !ended_.ok(); };
  if (command_.max_seconds > 0.0) {
    const std::chrono::duration<double> longest(std::min(command_.max_seconds, 1e8));
    changed_.wait_for(lock, stop, longest, has_ended);
  } else {
    changed_.wait(lock, stop, has_ended);
  }
  return ended_;
}

}  // namespace

absl::Status Run(const WhoCommand& command, const Console& console, std::stop_token stop) {
  const auto engine = ConnectTo(command.engine);
  if (!engine.ok()) return engine.status();
  WhoPrinter printer(command, console);
  PresenceCallback print = nullptr;
  if (command.watch) print = [&printer](const PresenceChange& change) { printer.Print(change); };
  const auto me = EnterScene(**engine, command.scene_id, command.person, std::move(print));
  if (!me.ok()) return me.status();
  if (command.watch) return printer.Wait(stop);
  const Attendance everybody = (*me)->attendance();
  if (command.json) {
    console.out << OneLineJson(WhoJson(command.scene_id, everybody)) << '\n';
  } else {
    console.out << WhoTable(command.scene_id, everybody, console.out_is_terminal);
  }
  return absl::OkStatus();
}

}  // namespace penumbra
