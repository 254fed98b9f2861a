// penumbra push: makes a server's scene equal to a file.
#include <nlohmann/json.hpp>
#include <optional>

#include "absl/strings/str_format.h"
#include "client/cli/json_text.h"
#include "client/cli/open_engine.h"
#include "client/cli/people.h"
#include "client/cli/replace_scene.h"
#include "client/cli/run_command.h"
#include "client/cli/shadow_plan.h"
#include "client/session/commit_in_parts.h"
#include "client/session/remote_engine.h"
#include "client/session/steady_clock.h"

namespace penumbra {
namespace {

void Report(const PushCommand& command, const ShadowPlan& plan, Revision revision,
            const UploadTraffic& traffic, double wall_ms, const Console& console) {
  for (const std::string& note : plan.notes) console.Note(note);
  if (plan.receiver_ids.empty()) {
    console.Note(
        "no receiver is named (--floor, --receiver, --receiver-instance, --every-polygon): until a "
        "client adds one soft_texture has nothing to show shadows on");
  }
  if (command.json) {
    const nlohmann::ordered_json json = {
        {"scene", command.scene_id},          {"revision", revision},
        {"blobs_sent", traffic.blobs_sent},   {"bytes_sent", traffic.bytes_sent},
        {"blobs_known", traffic.blobs_known}, {"wall_ms", wall_ms}};
    console.out << JsonText(json) << '\n';
  } else {
    console.out << absl::StrFormat(
        "%s is at revision %d: %d instances, %d lights, %d receivers, %.0f ms\n", command.scene_id,
        revision, plan.delta.upsert_instances.size(), plan.light_ids.size(),
        plan.receiver_ids.size(), wall_ms);
  }
}

}  // namespace

absl::Status Run(const PushCommand& command, const Console& console, std::stop_token) {
  const auto imported = ImportScene(command.request.scene);
  if (!imported.ok()) return imported.status();
  const auto plan = PlanShadows(*imported, command.request);
  if (!plan.ok()) return plan.status();

  ProgressLine progress(console);
  const auto show = [&](uint64_t sent, uint64_t total) {
    progress.Show(absl::StrFormat("%.1f of %.1f MB", sent * 1e-6, total * 1e-6),
                  total > 0 ? static_cast<double>(sent) / static_cast<double>(total) : 1.0);
  };
  const double start_ms = NowMs();
  const auto engine = ConnectTo(command.engine, show);
  if (!engine.ok()) return engine.status();
  const absl::Status created = (*engine)->CreateScene(command.scene_id);
  if (!created.ok() && !absl::IsAlreadyExists(created)) return created;
  const PersonChoice& person = command.person;
  std::optional<absl::StatusOr<PersonInScene>> me;
  if (person.name || person.takes_editing || person.takes_from_other) {
    me.emplace(EnterToEdit(**engine, command.scene_id, person));
    if (!me->ok()) return me->status();
  }
  const auto present = (*engine)->Snapshot(command.scene_id);
  if (!present.ok()) return present.status();

  // A lamp or a patch that others added goes too: the scene is the file's afterwards.
  const SceneDelta delta = ReplacementDelta(**present, plan->delta);
  absl::StatusOr<Revision> revision = (*present)->revision();
  if (!delta.empty()) revision = CommitInParts(**engine, command.scene_id, delta);
  if (!revision.ok()) return WithTakeHint(revision.status());

  const UploadTraffic traffic = (*engine)->upload_traffic();
  const double wall_ms = NowMs() - start_ms;
  progress.Finish(absl::StrFormat("sent %d blobs, %.2f MB; %d were there", traffic.blobs_sent,
                                  traffic.bytes_sent * 1e-6, traffic.blobs_known));
  Report(command, *plan, *revision, traffic, wall_ms, console);
  return absl::OkStatus();
}

}  // namespace penumbra
