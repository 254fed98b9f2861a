// penumbra demo: the main job from one end to the other. A scene goes to a server, an object and
// the lamp move, the shadows come back, and the scene is drawn here after each step.
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/draw_scene.h"
#include "client/cli/open_engine.h"
#include "client/cli/option_error.h"
#include "client/cli/output_files.h"
#include "client/cli/run_command.h"
#include "client/cli/scene_edit.h"
#include "client/cli/shadow_board.h"
#include "client/cli/shadow_plan.h"
#include "client/session/commit_in_parts.h"
#include "client/session/steady_clock.h"

namespace penumbra {
namespace {

// Enough to show several textures at work, few enough to be quick.
constexpr size_t kPlanarReceivers = 2;
constexpr size_t kMaxLights = 2;

ShadowRequest DemoRequest(const DemoCommand& command, const ImportedScene& imported) {
  ShadowRequest request{.scene = command.scene,
                        .floor = true,
                        .texels = command.texels,
                        .texels_option = "--texture-size",
                        .reflectance = Vec3(0.8f),
                        .params = command.params};
  if (InfoOf(command.params).target == SpecTarget::kReceiver) {
    request.receiver_instances = LargestPlanarInstances(imported, kPlanarReceivers);
  }
  for (const AreaLight& light : imported.lights) {
    if (request.light_ids.size() < kMaxLights) request.light_ids.push_back(light.id);
  }
  return request;
}

// The steps, and what they have in common.
class Demonstration {
 public:
  Demonstration(const DemoCommand& command, const Console& console, RemoteEngine& engine,
                std::string scene_id, std::stop_token stop)
      : command_(command),
        console_(console),
        engine_(engine),
        scene_id_(std::move(scene_id)),
        stop_(std::move(stop)) {}

  absl::Status Begin(const ShadowPlan& plan, const Camera& camera);
  absl::Status Step(const std::string& title, const std::string& picture,
                    absl::StatusOr<SceneDelta> (*edit)(const Scene&));

 private:
  absl::Status Show(const std::string& title, const std::string& picture, double start_ms,
                    double committed_ms, const ReceivedUpdates& received);

  const DemoCommand& command_;
  const Console& console_;
  RemoteEngine& engine_;
  const std::string scene_id_;
  const std::stop_token stop_;
  std::unique_ptr<Pencil> pencil_;
  DrawRequest draw_;
  ShadowBoard board_;
};

absl::Status Demonstration::Begin(const ShadowPlan& plan, const Camera& camera) {
  auto pencil = Pencil::Create();
  if (!pencil.ok()) return pencil.status();
  pencil_ = *std::move(pencil);
  draw_ = {.size = command_.size, .camera = camera};

  const double start_ms = NowMs();
  const auto revision = CommitInParts(engine_, scene_id_, plan.delta);
  if (!revision.ok()) return revision.status();
  const double committed_ms = NowMs();
  std::vector<ArtifactSpec> specs;
  for (const PlannedShadow& shadow : ShadowsOf(plan, command_.params)) {
    specs.push_back(shadow.spec);
  }
  if (absl::Status status = board_.Follow(engine_, scene_id_, specs); !status.ok()) return status;
  const auto received = board_.WaitFor(*revision, stop_);
  if (!received.ok()) return received.status();
  const UploadTraffic traffic = engine_.upload_traffic();
  console_.out << absl::StrFormat("sent %d meshes and masks, %.2f MB\n", traffic.blobs_sent,
                                  traffic.bytes_sent * 1e-6);
  return Show("the scene as it was sent", "1-before.png", start_ms, committed_ms, *received);
}

absl::Status Demonstration::Step(const std::string& title, const std::string& picture,
                                 absl::StatusOr<SceneDelta> (*edit)(const Scene&)) {
  const auto scene = engine_.Snapshot(scene_id_);
  if (!scene.ok()) return scene.status();
  const auto delta = edit(**scene);
  if (!delta.ok()) return delta.status();
  const double start_ms = NowMs();
  const auto revision = engine_.Commit(scene_id_, *delta);
  if (!revision.ok()) return revision.status();
  const double committed_ms = NowMs();
  const auto received = board_.WaitFor(*revision, stop_);
  if (!received.ok()) return received.status();
  return Show(title, picture, start_ms, committed_ms, *received);
}

absl::Status Demonstration::Show(const std::string& title, const std::string& picture,
                                 double start_ms, double committed_ms,
                                 const ReceivedUpdates& received) {
  const auto scene = engine_.Snapshot(scene_id_);
  if (!scene.ok()) return scene.status();
  const Shadows shadows = board_.shadows();
  const std::filesystem::path path = command_.out / picture;
  const auto drawn = pencil_->Draw(**scene, shadows, draw_, path);
  if (!drawn.ok()) return drawn.status();
  // One exposure for all the pictures, so that they can be compared.
  draw_.exposure = drawn->exposure;
  console_.out << absl::StrFormat(
      "%s (revision %d)\n"
      "  commit answered after %.1f ms, first shadows after %.1f ms, all final after %.1f ms\n"
      "  %d shadows in %d updates, %.1f kB; drawn in %.1f ms by %s\n"
      "  %s\n",
      title, (*scene)->revision(), committed_ms - start_ms, received.first_ms - start_ms,
      received.last_ms - start_ms, shadows.size(), received.updates, received.bytes * 1e-3,
      drawn->draw_ms, drawn->renderer, path.string());
  console_.out.flush();
  return absl::OkStatus();
}

}  // namespace

absl::Status Run(const DemoCommand& command, const Console& console, std::stop_token stop) {
  if (InfoOf(command.params).target == SpecTarget::kPoints) {
    return OptionError("--technique", "CONFLICT", {InfoOf(command.params).name},
                       ", which computes one picture, need a technique for any view");
  }
  const auto imported = ImportScene(command.scene);
  if (!imported.ok()) return imported.status();
  const auto plan = PlanShadows(*imported, DemoRequest(command, *imported));
  if (!plan.ok()) return plan.status();
  if (absl::Status status = PrepareOutputFolder(command.out); !status.ok()) return status;

  const auto engine = ConnectTo(command.engine);
  if (!engine.ok()) return engine.status();
  const auto scene = TemporaryScene::Create(**engine, "demo");
  if (!scene.ok()) return scene.status();
  Demonstration demonstration(command, console, **engine, scene->id(), stop);
  absl::Status status =
      demonstration.Begin(*plan, ChooseCamera(*imported, /*has_floor=*/true, command.size));
  if (status.ok()) status = demonstration.Step("an object moved", "2-object.png", MoveAnObject);
  if (status.ok()) {
    for (const std::string& note : plan->notes) console.Note(note);
  }
  if (status.ok()) status = demonstration.Step("the lamp moved", "3-lamp.png", MoveTheLamp);
  return status;
}

}  // namespace penumbra
