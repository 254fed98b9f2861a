#include "client/cli/view_picture.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <random>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/compute_shadow.h"
#include "client/cli/json_number.h"
#include "client/cli/json_text.h"
#include "client/display/thin_renderer.h"
#include "client/session/steady_clock.h"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

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

// A file beside it of the same kind that is nobody else's.
std::filesystem::path PartOf(const std::filesystem::path& path) {
  return path.parent_path() / absl::StrCat(".", path.stem().string(), ".", std::random_device()(),
                                           ".part", path.extension().string());
}

// The picture in one go: whoever looks at the file meanwhile sees the one before. A link goes on
// leading to it.
absl::StatusOr<DrawnPicture> DrawInPlaceOf(
    const std::filesystem::path& out,
    const std::function<absl::StatusOr<DrawnPicture>(const std::filesystem::path& path)>& draw) {
  std::error_code error;
  const std::filesystem::path target = std::filesystem::weakly_canonical(out, error);
  const std::filesystem::path part = PartOf(error ? out : target);
  auto drawn = draw(part);
  if (drawn.ok()) {
    std::filesystem::rename(part, error ? out : target, error);
    if (!error) return drawn;
    drawn = absl::UnavailableError(
        absl::StrCat(out.native(), ": cannot be replaced: ", error.message()));
  }
  std::filesystem::remove(part, error);
  return drawn;
}

}  // namespace

absl::Status ReceiveShadows(Engine& engine, const std::string& scene_id,
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

absl::Status DrawView(const ViewCommand& command, Pencil& pencil, const Camera& camera,
                      const Scene& scene, const Shadows& shadows, const Console& console) {
  const DrawRequest draw{.size = command.size,
                         .camera = camera,
                         .ambient = command.ambient,
                         .exposure = command.exposure,
                         .volume_look = command.volume_look.value_or(VolumeLook{}),
                         .culls_back_faces = command.culls_back_faces};
  const auto draw_into = [&](const std::filesystem::path& path) {
    return pencil.Draw(scene, shadows, draw, path);
  };
  const auto drawn = command.watch ? DrawInPlaceOf(command.out, draw_into) : draw_into(command.out);
  if (!drawn.ok()) return drawn.status();
  if (command.json) {
    Json json = ToJson(command, shadows.size(), *drawn);
    if (!command.scene_id.empty()) json["revision"] = scene.revision();
    console.out << JsonText(json, command.watch ? -1 : 2) << std::endl;
  } else {
    console.out << absl::StrFormat("wrote %s with %d shadow%s, drawn in %.1f ms by %s",
                                   command.out.string(), shadows.size(),
                                   shadows.size() == 1 ? "" : "s", drawn->draw_ms, drawn->renderer)
                << std::endl;
  }
  return absl::OkStatus();
}

}  // namespace penumbra
