// penumbra push: makes a server's scene equal to a file.
#include <nlohmann/json.hpp>

#include "absl/strings/str_format.h"
#include "client/cli/open_engine.h"
#include "client/cli/replace_scene.h"
#include "client/cli/run_command.h"
#include "client/import/import_scene.h"
#include "client/session/remote_engine.h"
#include "client/session/steady_clock.h"

namespace penumbra {
namespace {

void Report(const PushCommand& command, const ImportedScene& imported, Revision revision,
            const UploadTraffic& traffic, double wall_ms, const Console& console) {
  if (command.json) {
    const nlohmann::ordered_json json = {
        {"scene", command.scene_id},          {"revision", revision},
        {"blobs_sent", traffic.blobs_sent},   {"bytes_sent", traffic.bytes_sent},
        {"blobs_known", traffic.blobs_known}, {"wall_ms", wall_ms}};
    console.out << json.dump(2) << '\n';
  } else {
    console.out << absl::StrFormat("%s is at revision %d: %d instances, %d lights, %.0f ms\n",
                                   command.scene_id, revision, imported.instances.size(),
                                   imported.lights.size(), wall_ms);
  }
}

}  // namespace

absl::Status Run(const PushCommand& command, const Console& console, std::stop_token) {
  const auto imported = ImportScene(command.scene);
  if (!imported.ok()) return imported.status();
  for (const std::string& warning : imported->warnings) console.Note(warning);

  ProgressLine progress(console);
  const auto show = [&](uint64_t sent, uint64_t total) {
    progress.Show(absl::StrFormat("%.1f of %.1f MB", sent * 1e-6, total * 1e-6),
                  total > 0 ? static_cast<double>(sent) / static_cast<double>(total) : 1.0);
  };
  const double start_ms = NowMs();
  const auto engine =
      RemoteEngine::Connect({.address = command.engine.server, .upload_progress = show});
  if (!engine.ok()) return engine.status();
  const absl::Status created = (*engine)->CreateScene(command.scene_id);
  if (!created.ok() && !absl::IsAlreadyExists(created)) return created;
  const auto present = (*engine)->Snapshot(command.scene_id);
  if (!present.ok()) return present.status();

  // A lamp or a patch that others added goes too: the scene is the file's afterwards.
  const SceneDelta delta = ReplacementDelta(**present, ToSceneDelta(*imported));
  absl::StatusOr<Revision> revision = (*present)->revision();
  if (!delta.empty()) revision = (*engine)->Commit(command.scene_id, delta);
  if (!revision.ok()) return revision.status();

  const UploadTraffic traffic = (*engine)->upload_traffic();
  const double wall_ms = NowMs() - start_ms;
  progress.Finish(absl::StrFormat("sent %d blobs, %.2f MB; %d were there", traffic.blobs_sent,
                                  traffic.bytes_sent * 1e-6, traffic.blobs_known));
  Report(command, *imported, *revision, traffic, wall_ms, console);
  return absl::OkStatus();
}

}  // namespace penumbra
