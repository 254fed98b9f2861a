// penumbra scenes diff.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "absl/strings/str_cat.h"
#include "client/cli/json_text.h"
#include "client/cli/open_engine.h"
#include "client/cli/option_error.h"
#include "client/cli/run_command.h"
#include "client/cli/scene_diff.h"
#include "client/session/scene_archive.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;
using Kind = ObjectChange::Kind;

// Archives are read, scenes are asked for; connects when it first has to.
class Scenes {
 public:
  explicit Scenes(const EngineChoice& choice) : choice_(choice) {}

  absl::StatusOr<std::shared_ptr<const Scene>> Find(const std::string& name,
                                                    const std::stop_token& stop) {
    std::error_code error;
    if (std::filesystem::is_regular_file(name, error)) {
      auto info = ReadArchive(name, {.stop = stop});
      if (!info.ok()) return info.status();
      return info->scene;
    }
    if (choice_.server.empty()) {
      return absl::NotFoundError(absl::StrCat(
          OneLine(name), ": found no such file, need an archive, or --server for a scene's id"));
    }
    if (!engine_) {
      auto engine = ConnectTo(choice_);
      if (!engine.ok()) return engine.status();
      engine_ = *std::move(engine);
    }
    return engine_->Snapshot(name);
  }

 private:
  const EngineChoice& choice_;
  std::unique_ptr<RemoteEngine> engine_;
};

Json SideJson(const std::string& name, const Scene& scene) {
  return {
      {"name", name}, {"revision", scene.revision()}, {"content_hash", scene.content_hash().hex()}};
}

Json ChangesJson(const std::vector<ObjectChange>& changes, Kind kind) {
  Json list = Json::array();
  for (const ObjectChange& change : changes) {
    if (change.kind != kind) continue;
    Json entry = {{"object", change.object}, {"id", change.id}};
    for (const FieldChange& field : change.fields) {
      entry["fields"].push_back({{"field", field.field}, {"from", field.from}, {"to", field.to}});
    }
    list.push_back(std::move(entry));
  }
  return list;
}

void PrintChanges(const std::vector<ObjectChange>& changes, std::ostream& out) {
  size_t added = 0, removed = 0;
  for (const ObjectChange& change : changes) {
    added += change.kind == Kind::kAdded;
    removed += change.kind == Kind::kRemoved;
    const char* const sign = change.kind == Kind::kAdded     ? "+ "
                             : change.kind == Kind::kRemoved ? "- "
                                                             : "~ ";
    out << sign << change.object << ' ' << change.id << '\n';
    for (const FieldChange& field : change.fields) {
      out << "    " << field.field << ": " << (field.from.empty() ? "none" : field.from) << " -> "
          << (field.to.empty() ? "none" : field.to) << '\n';
    }
  }
  out << added << " added, " << removed << " removed, " << changes.size() - added - removed
      << " changed\n";
}

}  // namespace

absl::Status Run(const ScenesDiffCommand& command, const Console& console, std::stop_token stop) {
  Scenes scenes(command.engine);
  const auto from = scenes.Find(command.from, stop);
  if (!from.ok()) return from.status();
  const auto to = scenes.Find(command.to, stop);
  if (!to.ok()) return to.status();
  const std::vector<ObjectChange> changes = DiffScenes(**from, **to);
  const bool are_equal = (*from)->content_hash() == (*to)->content_hash();
  if (command.json) {
    const Json json = {{"from", SideJson(command.from, **from)},
                       {"to", SideJson(command.to, **to)},
                       {"are_equal", are_equal},
                       {"added", ChangesJson(changes, Kind::kAdded)},
                       {"removed", ChangesJson(changes, Kind::kRemoved)},
                       {"changed", ChangesJson(changes, Kind::kChanged)}};
    console.out << JsonText(json) << '\n';
  } else {
    PrintChanges(changes, console.out);
  }
  if (are_equal) return absl::OkStatus();
  return FieldError(absl::StatusCode::kFailedPrecondition, kScenesDiffer, "", "the scenes differ");
}

}  // namespace penumbra
