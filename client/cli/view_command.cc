// penumbra view: receives textures as any client would, and draws with them.
#include <string>

#include "client/cli/draw_scene.h"
#include "client/cli/fitting_options.h"
#include "client/cli/open_engine.h"
#include "client/cli/output_files.h"
#include "client/cli/run_command.h"
#include "client/cli/shadow_plan.h"
#include "client/cli/view_picture.h"
#include "client/cli/view_server_scene.h"
#include "client/session/commit_in_parts.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

constexpr uint32_t kPlanarReceivers = 4;

// Adds the scene's own flat surfaces where the request names none, or a floor where there are none.
ShadowRequest WithReceivers(ShadowRequest request, const ImportedScene& imported, size_t count) {
  if (InfoOf(request.params).target != SpecTarget::kReceiver) return request;
  if (request.every_polygon || !request.receivers.empty() || !request.receiver_instances.empty()) {
    return request;
  }
  request.receiver_instances = LargestPlanarInstances(imported, count);
  if (request.receiver_instances.empty()) request.floor = true;
  return request;
}

// Boundaries leave out what lies on surfaces that are drawn: where back faces are not, all of each
// is needed. Returns whether that is more than was asked for.
bool NeedWholeVolumes(const ViewCommand& command, TechniqueParams& params) {
  auto* const volumes = std::get_if<ShadowVolumeParams>(&params);
  if (volumes == nullptr || !command.culls_back_faces) return false;
  const ShadowVolumeParams before = *volumes;
  volumes->surface = VolumeSurface::kAll;
  if (volumes->volumes_of == VolumesOf::kEdges) volumes->volumes_of = VolumesOf::kInstances;
  return *volumes != before;
}

absl::Status CheckSource(const ViewCommand& command) {
  if (command.scene_id.empty() != command.request.scene.empty()) return absl::OkStatus();
  return FieldError(absl::StatusCode::kInvalidArgument, "MISSING_OPTION", "--scene",
                    "found neither it nor a SCENE, need a server's scene or a file");
}

absl::Status ViewFile(const ViewCommand& command, const Console& console,
                      const std::stop_token& stop) {
  const auto imported = ImportScene(command.request.scene);
  if (!imported.ok()) return imported.status();
  const ShadowRequest request = WithReceivers(
      command.request, *imported, command.max_planar_receivers.value_or(kPlanarReceivers));
  auto plan = PlanShadows(*imported, request);
  if (!plan.ok()) return plan.status();
  if (request.floor && !command.request.floor) {
    plan->notes.push_back("no flat instance receives: a floor under the scene does");
  }
  absl::Status status = PrepareOutputFile(command.out);
  if (!status.ok()) return status;

  const auto engine = OpenEngine(command.engine);
  if (!engine.ok()) return engine.status();
  const auto temporary = TemporaryScene::Create(**engine, "view");
  if (!temporary.ok()) return temporary.status();
  const auto revision = CommitInParts(**engine, temporary->id(), plan->delta);
  if (!revision.ok()) return revision.status();
  const Camera camera =
      command.camera.value_or(ChooseCamera(*imported, request.floor, command.size));
  const auto pencil = Pencil::Create();
  if (!pencil.ok()) return pencil.status();
  Shadows shadows;
  status = ReceiveShadows(**engine, temporary->id(), WantedShadows(command, *plan, camera),
                          (*pencil)->room(), console, stop, shadows);
  if (!status.ok()) return status;
  const auto scene = (*engine)->Snapshot(temporary->id());
  if (!scene.ok()) return scene.status();

  for (const std::string& note : plan->notes) console.Note(note);
  return DrawView(command, **pencil, camera, **scene, shadows, console);
}

}  // namespace

absl::Status Run(const ViewCommand& asked, const Console& console, std::stop_token stop) {
  ViewCommand command = asked;
  absl::Status status = CheckSource(command);
  if (status.ok()) status = CheckPicturePath(command.out);
  if (status.ok()) status = CheckOptionsFit(command);
  if (!status.ok()) return status;
  if (NeedWholeVolumes(command, command.request.params)) {
    console.Note("back faces are left out: shadow volumes have all of their surface (surface=all)");
  }
  if (command.scene_id.empty()) return ViewFile(command, console, stop);
  status = PrepareOutputFile(command.out);
  return status.ok() ? ViewServerScene(command, console, stop) : status;
}

}  // namespace penumbra
