// penumbra view: receives textures as any client would, and draws with them.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/compute_shadow.h"
#include "client/cli/draw_scene.h"
#include "client/cli/open_engine.h"
#include "client/cli/output_files.h"
#include "client/cli/run_command.h"
#include "client/cli/shadow_plan.h"
#include "client/session/commit_in_parts.h"
#include "client/session/steady_clock.h"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

// Adds the scene's own flat surfaces where the request names none, or a floor where there are none.
ShadowRequest WithReceivers(ShadowRequest request, const ImportedScene& imported, size_t count) {
  if (request.every_polygon || !request.receivers.empty() || !request.receiver_instances.empty()) {
    return request;
  }
  request.receiver_instances = LargestPlanarInstances(imported, count);
  if (request.receiver_instances.empty()) request.floor = true;
  return request;
}

Json ToJson(const ViewCommand& command, size_t textures, const DrawnPicture& drawn) {
  const Camera& camera = drawn.camera;
  return {{"out", command.out.string()},
          {"width", command.size.width},
          {"height", command.size.height},
          {"textures", textures},
          {"camera",
           {{"eye", {camera.eye.x, camera.eye.y, camera.eye.z}},
            {"target", {camera.target.x, camera.target.y, camera.target.z}},
            {"up", {camera.up.x, camera.up.y, camera.up.z}},
            {"fov_y_deg", camera.fov_y_deg}}},
          {"exposure", drawn.exposure},
          {"renderer", drawn.renderer},
          {"draw_ms", drawn.draw_ms}};
}

absl::StatusOr<Shadows> Receive(Engine& engine, const std::string& scene_id, const ShadowPlan& plan,
                                const TechniqueParams& params, const Console& console,
                                std::stop_token stop) {
  Shadows shadows;
  ProgressLine progress(console);
  for (const std::string& receiver_id : plan.receiver_ids) {
    for (const std::string& light_id : plan.light_ids) {
      const std::string label = absl::StrCat(receiver_id, " in the light of ", light_id);
      const double start_ms = NowMs();
      auto artifact =
          ComputeShadow(engine, scene_id, {params, light_id, receiver_id}, label, progress, stop);
      if (!artifact.ok()) return artifact.status();
      progress.Finish(absl::StrFormat("%s: %.1f ms", label, NowMs() - start_ms));
      shadows.push_back(*std::move(artifact));
    }
  }
  return shadows;
}

absl::Status Draw(const ViewCommand& command, const Camera& camera, const Scene& scene,
                  const Shadows& shadows, const Console& console) {
  const DrawRequest draw{.size = command.size,
                         .camera = camera,
                         .ambient = command.ambient,
                         .exposure = command.exposure,
                         .culls_back_faces = command.culls_back_faces};
  auto pencil = Pencil::Create();
  if (!pencil.ok()) return pencil.status();
  const auto drawn = (*pencil)->Draw(scene, shadows, draw, command.out);
  if (!drawn.ok()) return drawn.status();
  if (command.json) {
    console.out << ToJson(command, shadows.size(), *drawn).dump(2) << '\n';
  } else {
    console.out << absl::StrFormat("wrote %s with %d texture%s, drawn in %.1f ms by %s\n",
                                   command.out.string(), shadows.size(),
                                   shadows.size() == 1 ? "" : "s", drawn->draw_ms, drawn->renderer);
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status Run(const ViewCommand& command, const Console& console, std::stop_token stop) {
  const auto imported = ImportScene(command.request.scene);
  if (!imported.ok()) return imported.status();
  const ShadowRequest request =
      WithReceivers(command.request, *imported, command.max_planar_receivers);
  auto plan = PlanShadows(*imported, request);
  if (!plan.ok()) return plan.status();
  if (request.floor && !command.request.floor) {
    plan->notes.push_back("no flat instance receives: a floor under the scene does");
  }
  absl::Status status = CheckPicturePath(command.out);
  if (status.ok()) status = PrepareOutputFile(command.out);
  if (!status.ok()) return status;

  const auto engine = OpenEngine(command.engine);
  if (!engine.ok()) return engine.status();
  const auto temporary = TemporaryScene::Create(**engine, "view");
  if (!temporary.ok()) return temporary.status();
  const auto revision = CommitInParts(**engine, temporary->id(), plan->delta);
  if (!revision.ok()) return revision.status();
  const auto shadows = Receive(**engine, temporary->id(), *plan, request.params, console, stop);
  if (!shadows.ok()) return shadows.status();
  const auto scene = (*engine)->Snapshot(temporary->id());
  if (!scene.ok()) return scene.status();

  for (const std::string& note : plan->notes) console.Note(note);
  const Camera camera =
      command.camera.value_or(ChooseCamera(*imported, request.floor, command.size));
  return Draw(command, camera, **scene, *shadows, console);
}

}  // namespace penumbra
