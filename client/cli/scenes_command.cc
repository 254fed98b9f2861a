// penumbra scenes list, export, import and delete.
#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/json_text.h"
#include "client/cli/open_engine.h"
#include "client/cli/output_files.h"
#include "client/cli/run_command.h"
#include "client/cli/server_json.h"
#include "client/cli/status_table.h"
#include "client/session/scene_archive.h"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kNameColumns = 32;

// How many sessions are on each scene; none where this client may not know.
absl::StatusOr<std::map<std::string, double>> ClientsOf(RemoteEngine& engine) {
  const auto status = AskServer(engine, &RemoteEngine::ServerStatusJson);
  if (!status.ok()) return status.status();
  std::map<std::string, double> clients;
  for (const Json& scene : status->value("scenes", Json::array())) {
    clients[TextAt(scene, "scene_id")] = NumberAt(scene, "clients");
  }
  return clients;
}

Json SceneRow(const Json& scene, const absl::StatusOr<std::map<std::string, double>>& clients) {
  const std::string id = TextAt(scene, "scene_id");
  std::string hash;
  absl::Base64Unescape(TextAt(scene, "content_hash"), &hash);
  const auto number = [&](const char* name) {
    return static_cast<uint64_t>(NumberAt(scene, name));
  };
  Json row = {{"id", id},
              {"revision", number("revision")},
              {"content_hash", absl::BytesToHexString(hash)},
              {"instances", number("instance_count")},
              {"lights", number("light_count")},
              {"receivers", number("receiver_count")}};
  if (clients.ok()) {
    const auto found = clients->find(id);
    row["clients"] = found == clients->end() ? 0 : static_cast<uint64_t>(found->second);
  }
  if (const std::string damage = TextAt(scene, "damage"); !damage.empty()) row["damage"] = damage;
  return row;
}

void PrintTable(const Json& rows, std::ostream& out) {
  out << CellText("SCENE", kNameColumns) << "   REVISION INSTANCES  LIGHTS RECEIVERS CLIENTS\n";
  for (const Json& row : rows) {
    out << CellText(TextAt(row, "id"), kNameColumns);
    if (row.contains("damage")) {
      out << " refused: " << CellText(TextAt(row, "damage"), TextAt(row, "damage").size()) << '\n';
      continue;
    }
    const std::string clients =
        row.contains("clients") ? absl::StrFormat("%.0f", NumberAt(row, "clients")) : "-";
    out << absl::StrFormat(" %10.0f %9.0f %7.0f %9.0f %7s\n", NumberAt(row, "revision"),
                           NumberAt(row, "instances"), NumberAt(row, "lights"),
                           NumberAt(row, "receivers"), clients);
  }
}

}  // namespace

absl::Status Run(const ScenesListCommand& command, const Console& console, std::stop_token) {
  const auto engine = ConnectTo(command.engine);
  if (!engine.ok()) return engine.status();
  const auto scenes = AskServer(**engine, &RemoteEngine::ScenesJson);
  if (!scenes.ok()) return scenes.status();
  const auto clients = ClientsOf(**engine);
  if (!clients.ok() && !absl::IsPermissionDenied(clients.status())) return clients.status();
  Json rows = Json::array();
  for (const Json& scene : scenes->value("scenes", Json::array())) {
    rows.push_back(SceneRow(scene, clients));
  }
  if (command.json) {
    console.out << JsonText(rows) << '\n';
  } else {
    PrintTable(rows, console.out);
  }
  return absl::OkStatus();
}

absl::Status Run(const ScenesExportCommand& command, const Console& console, std::stop_token stop) {
  if (auto status = PrepareOutputFile(command.file); !status.ok()) return status;
  const auto engine = ConnectTo(command.engine);
  if (!engine.ok()) return engine.status();
  ProgressLine progress(console);
  const ArchiveOptions options{
      .with_history = !command.without_history,
      .progress = [&](uint64_t moved, uint64_t) { progress.Show(BytesText(moved), 0.0); },
      .stop = stop};
  if (auto status = (*engine)->ExportScene(command.scene_id, command.file, options); !status.ok()) {
    return status;
  }
  // Read back: what has been written can be relied on.
  const auto info = ReadArchive(command.file, {.stop = stop});
  if (!info.ok()) return info.status();
  const uint64_t commits = info->revision - info->base_revision;
  if (command.json) {
    const Json json = {{"scene", info->scene_id},
                       {"revision", info->revision},
                       {"content_hash", info->scene->content_hash().hex()},
                       {"commits", commits},
                       {"blobs", info->blobs.size()},
                       {"bytes", info->file_bytes},
                       {"file", command.file.string()}};
    console.out << JsonText(json) << '\n';
    return absl::OkStatus();
  }
  console.out << absl::StrFormat("%s: %s at revision %d, %d commits, %d blobs, %s\n",
                                 command.file.string(), info->scene_id, info->revision, commits,
                                 info->blobs.size(), BytesText(info->file_bytes));
  return absl::OkStatus();
}

absl::Status Run(const ScenesImportCommand& command, const Console& console, std::stop_token stop) {
  const auto engine = ConnectTo(command.engine);
  if (!engine.ok()) return engine.status();
  ProgressLine progress(console);
  const ArchiveOptions options{.progress =
                                   [&](uint64_t moved, uint64_t total) {
                                     progress.Show(
                                         BytesText(moved),
                                         static_cast<double>(moved) / static_cast<double>(total));
                                   },
                               .stop = stop};
  const auto scene = (*engine)->ImportScene(command.file, command.scene_id, options);
  if (!scene.ok()) return scene.status();
  if (command.json) {
    const Json json = {{"scene", scene->id},
                       {"revision", scene->revision},
                       {"content_hash", scene->content_hash.hex()},
                       {"instances", scene->instance_count},
                       {"lights", scene->light_count},
                       {"receivers", scene->receiver_count}};
    console.out << JsonText(json) << '\n';
    return absl::OkStatus();
  }
  console.out << absl::StrFormat("%s is at revision %d: %d instances, %d lights, %d receivers\n",
                                 scene->id, scene->revision, scene->instance_count,
                                 scene->light_count, scene->receiver_count);
  return absl::OkStatus();
}

absl::Status Run(const ScenesDeleteCommand& command, const Console& console, std::stop_token) {
  const auto engine = ConnectTo(command.engine);
  if (!engine.ok()) return engine.status();
  for (const std::string& id : command.scene_ids) {
    if (auto status = (*engine)->DeleteScene(id); !status.ok()) return status;
    console.out << "deleted " << id << '\n';
  }
  return absl::OkStatus();
}

}  // namespace penumbra
