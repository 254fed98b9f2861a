// penumbra view: receives textures as any client would, and draws with them.
#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/compute_shadow.h"
#include "client/cli/draw_scene.h"
#include "client/cli/fitting_options.h"
#include "client/cli/json_number.h"
#include "client/cli/open_engine.h"
#include "client/cli/output_files.h"
#include "client/cli/run_command.h"
#include "client/cli/shadow_plan.h"
#include "client/display/thin_renderer.h"
#include "client/session/commit_in_parts.h"
#include "client/session/steady_clock.h"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

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

Json ToJson(Vec3 v) { return {JsonNumber(v.x), JsonNumber(v.y), JsonNumber(v.z)}; }

Json ToJson(const ViewCommand& command, size_t shadows, const DrawnPicture& drawn) {
  const Camera& camera = drawn.camera;
  return {{"out", command.out.string()},
          {"width", command.size.width},
          {"height", command.size.height},
          {"shadows", shadows},
          {"camera",
           {{"eye", ToJson(camera.eye)},
            {"target", ToJson(camera.target)},
            {"up", ToJson(camera.up)},
            {"fov_y_deg", JsonNumber(camera.fov_y_deg)}}},
          {"exposure", JsonNumber(drawn.exposure)},
          {"renderer", drawn.renderer},
          {"draw_ms", drawn.draw_ms}};
}

// Appends to `shadows`.
absl::Status Receive(Engine& engine, const std::string& scene_id,
                     const std::vector<PlannedShadow>& wanted, const DrawRoom& room,
                     const Console& console, const std::stop_token& stop, Shadows& shadows) {
  ProgressLine progress(console);
  const auto compute = [&](const PlannedShadow& shadow) {
    return ComputeShadow(engine, scene_id, shadow.spec, shadow.name, progress, stop);
  };
  if (const auto status = CheckWidthsFit(wanted, room, compute); !status.ok()) return status;
  for (const PlannedShadow& shadow : wanted) {
    const double start_ms = NowMs();
    auto artifact = compute(shadow);
    if (!artifact.ok()) return artifact.status();
    progress.Finish(absl::StrFormat("%s: %.1f ms", shadow.name, NowMs() - start_ms));
    NoteWarning(**artifact, shadow.name, console);
    shadows.push_back(*std::move(artifact));
  }
  return absl::OkStatus();
}

// The final picture's shadows: as many pixels as are shaded, in each light.
std::vector<PlannedShadow> FinalShadows(const ViewCommand& command, const ShadowPlan& plan,
                                        const Camera& camera) {
  const bool is_chosen = InfoOf(command.request.params).target == SpecTarget::kPoints;
  const TechniqueParams& params = is_chosen ? command.request.params : command.final_params;
  const auto n = static_cast<uint32_t>(RenderOptions{}.samples_per_side);
  const PicturePixels picture{
      .camera = camera, .width = n * command.size.width, .height = n * command.size.height};
  ShadowPlan final_plan{.delta = {}, .light_ids = plan.light_ids};
  final_plan.points.push_back({"final picture", picture});
  return ShadowsOf(final_plan, params);
}

// In the order in which they are computed: those of any view, the final picture's.
std::vector<PlannedShadow> WantedShadows(const ViewCommand& command, const ShadowPlan& plan,
                                         const Camera& camera) {
  // coherent_raytrace makes nothing but final pictures.
  const TechniqueParams& params = command.request.params;
  const bool has_views = InfoOf(params).target != SpecTarget::kPoints;
  std::vector<PlannedShadow> wanted;
  if (has_views) wanted = ShadowsOf(plan, params);
  if (command.final || !has_views) {
    std::ranges::move(FinalShadows(command, plan, camera), std::back_inserter(wanted));
  }
  return wanted;
}

absl::Status Draw(const ViewCommand& command, Pencil& pencil, const Camera& camera,
                  const Scene& scene, const Shadows& shadows, const Console& console) {
  const DrawRequest draw{.size = command.size,
                         .camera = camera,
                         .ambient = command.ambient,
                         .exposure = command.exposure,
                         .volume_look = command.volume_look.value_or(VolumeLook{}),
                         .culls_back_faces = command.culls_back_faces};
  const auto drawn = pencil.Draw(scene, shadows, draw, command.out);
  if (!drawn.ok()) return drawn.status();
  if (command.json) {
    console.out << ToJson(command, shadows.size(), *drawn).dump(2) << '\n';
  } else {
    console.out << absl::StrFormat("wrote %s with %d shadow%s, drawn in %.1f ms by %s\n",
                                   command.out.string(), shadows.size(),
                                   shadows.size() == 1 ? "" : "s", drawn->draw_ms, drawn->renderer);
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status Run(const ViewCommand& asked, const Console& console, std::stop_token stop) {
  ViewCommand command = asked;
  absl::Status status = CheckPicturePath(command.out);
  if (status.ok()) status = CheckOptionsFit(command);
  if (!status.ok()) return status;
  if (NeedWholeVolumes(command, command.request.params)) {
    console.Note("back faces are left out: shadow volumes have all of their surface (surface=all)");
  }
  const auto imported = ImportScene(command.request.scene);
  if (!imported.ok()) return imported.status();
  const ShadowRequest request = WithReceivers(
      command.request, *imported, command.max_planar_receivers.value_or(kPlanarReceivers));
  auto plan = PlanShadows(*imported, request);
  if (!plan.ok()) return plan.status();
  if (request.floor && !command.request.floor) {
    plan->notes.push_back("no flat instance receives: a floor under the scene does");
  }
  status = PrepareOutputFile(command.out);
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
  status = Receive(**engine, temporary->id(), WantedShadows(command, *plan, camera),
                   (*pencil)->room(), console, stop, shadows);
  if (!status.ok()) return status;
  const auto scene = (*engine)->Snapshot(temporary->id());
  if (!scene.ok()) return scene.status();

  for (const std::string& note : plan->notes) console.Note(note);
  return Draw(command, **pencil, camera, **scene, shadows, console);
}

}  // namespace penumbra
