#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/bake_files.h"
#include "client/cli/compute_shadow.h"
#include "client/cli/fitting_options.h"
#include "client/cli/json_text.h"
#include "client/cli/open_engine.h"
#include "client/cli/output_files.h"
#include "client/cli/run_command.h"
#include "client/cli/shadow_plan.h"
#include "client/session/commit_in_parts.h"
#include "client/session/steady_clock.h"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

// `wanted`, or with a number where that is one of `taken`.
std::string UniqueName(const std::string& wanted, std::set<std::string>& taken) {
  std::string name = wanted;
  for (int number = 2; !taken.insert(name).second; ++number) {
    name = absl::StrCat(wanted, "-", number);
  }
  return name;
}

// Of the texels on the receiver.
size_t InsideCount(const ShadowTexels& texels) {
  return texels.coverage ? texels.coverage->CountInside() : texels.visibility.counts.size();
}

double VisiblePercent(const ShadowTexels& texels) {
  const VisibilityMap& map = texels.visibility;
  double sum = 0.0;
  for (size_t k = 0; k < map.counts.size(); ++k) {
    if (!texels.coverage || texels.coverage->At(k)) sum += map.counts[k];
  }
  const double most = static_cast<double>(InsideCount(texels)) * map.sample_count;
  return most > 0.0 ? 100.0 * sum / most : 100.0;
}

size_t LayerCount(const AttenuationLdi& ldi) {
  size_t layers = 0;
  for (const LdiFace& face : ldi.faces) layers += face.layer_count();
  return layers;
}

size_t TexelCount(const ShadowWidthMap& map) {
  size_t texels = 0;
  for (const ShadowWidthFace& face : map.faces) texels += face.near.widths.size();
  return texels;
}

// Of artifacts that are of what the light sees: faces, or volumes. Nullopt for others.
std::optional<size_t> SeenCount(const ArtifactPayload& payload) {
  if (const auto* mesh = std::get_if<ShadowVolumeMesh>(&payload)) return mesh->volumes.size();
  if (const auto* ldi = std::get_if<AttenuationLdi>(&payload)) return ldi->faces.size();
  if (const auto* map = std::get_if<ShadowWidthMap>(&payload)) return map->faces.size();
  return std::nullopt;
}

std::string Describe(const BakeRecord& record) {
  if (const auto* mesh = std::get_if<ShadowVolumeMesh>(&record.artifact.payload)) {
    return absl::StrFormat("%s: %d triangles of %d volume%s, %.1f ms", record.name,
                           mesh->triangle_count(), mesh->volumes.size(),
                           mesh->volumes.size() == 1 ? "" : "s", record.wall_ms);
  }
  if (const auto* map = std::get_if<ShadowWidthMap>(&record.artifact.payload)) {
    return absl::StrFormat("%s: %d texels on %d face%s, %.1f ms", record.name, TexelCount(*map),
                           map->faces.size(), map->faces.size() == 1 ? "" : "s", record.wall_ms);
  }
  if (const auto* ldi = std::get_if<AttenuationLdi>(&record.artifact.payload)) {
    return absl::StrFormat("%s: %d layers on %d face%s, %d light samples, %.1f ms", record.name,
                           LayerCount(*ldi), ldi->faces.size(), ldi->faces.size() == 1 ? "" : "s",
                           ldi->sample_count, record.wall_ms);
  }
  const ShadowTexels& texels = *TexelsOf(record.artifact.payload);
  const VisibilityMap& map = texels.visibility;
  return absl::StrFormat("%s: %dx%d texels, %d light samples, %.1f %% visible, %.1f ms",
                         record.name, map.width, map.height, map.sample_count,
                         VisiblePercent(texels), record.wall_ms);
}

Json ToJson(const BakeRecord& record, const BakeCommand& command,
            const std::vector<std::string>& files) {
  Json paths = Json::array();
  for (const std::string& file : files) paths.push_back((command.out / file).string());
  const ArtifactHeader& header = record.artifact.header;
  Json json = {{"name", record.name}};
  if (!header.receiver_id.empty()) json["receiver"] = header.receiver_id;
  json["light"] = header.light_id;
  if (const ShadowTexels* texels = TexelsOf(record.artifact.payload)) {
    json["width"] = texels->visibility.width;
    json["height"] = texels->visibility.height;
    json["inside_texels"] = InsideCount(*texels);
    json["visible_percent"] = VisiblePercent(*texels);
  } else if (const auto* ldi = std::get_if<AttenuationLdi>(&record.artifact.payload)) {
    json["layers"] = LayerCount(*ldi);
  } else if (const auto* map = std::get_if<ShadowWidthMap>(&record.artifact.payload)) {
    json["texels"] = TexelCount(*map);
  } else {
    json["triangles"] = std::get<ShadowVolumeMesh>(record.artifact.payload).triangle_count();
  }
  json["files"] = std::move(paths);
  json["wall_ms"] = record.wall_ms;
  return json;
}

// Computes and writes each shadow of the plan.
absl::StatusOr<Json> BakeAll(const BakeCommand& command, const ShadowPlan& plan, Engine& engine,
                             const std::string& scene_id, const Console& console,
                             std::stop_token stop) {
  Json baked = Json::array();
  std::set<std::string> taken;
  ProgressLine progress(console);
  for (const auto& [spec, wanted] : ShadowsOf(plan, command.request.params)) {
    const std::string name = UniqueName(wanted, taken);
    const double start_ms = NowMs();
    const auto artifact = ComputeShadow(engine, scene_id, spec, name, progress, stop);
    if (!artifact.ok()) return artifact.status();
    if (SeenCount((*artifact)->payload) == 0) {
      progress.Finish(absl::StrCat(name, ": the light sees nothing, no file is written"));
      continue;
    }
    const BakeRecord record{.artifact = **artifact,
                            .scene = command.request.scene.string(),
                            .name = name,
                            .exposure = command.exposure,
                            .wall_ms = NowMs() - start_ms};
    const auto files = WriteBake(record, command.out);
    if (!files.ok()) return files.status();
    progress.Finish(Describe(record));
    NoteWarning(**artifact, name, console);
    baked.push_back(ToJson(record, command, *files));
  }
  return baked;
}

}  // namespace

absl::Status Run(const BakeCommand& command, const Console& console, std::stop_token stop) {
  ShadowRequest request = command.request;
  const bool takes_receivers = InfoOf(request.params).target == SpecTarget::kReceiver;
  const bool names_none = takes_receivers && request.receivers.empty() &&
                          request.receiver_instances.empty() && !request.every_polygon;
  request.floor = request.floor || names_none;
  if (absl::Status status = CheckOptionsFit(request); !status.ok()) return status;
  const auto imported = ImportScene(request.scene);
  if (!imported.ok()) return imported.status();
  auto plan = PlanShadows(*imported, request);
  if (!plan.ok()) return plan.status();
  if (!command.request.floor && names_none) {
    plan->notes.push_back("no receiver is named: a floor under the scene receives");
  }
  if (absl::Status status = PrepareOutputFolder(command.out); !status.ok()) return status;

  const auto engine = OpenEngine(command.engine);
  if (!engine.ok()) return engine.status();
  const auto scene = TemporaryScene::Create(**engine, "bake");
  if (!scene.ok()) return scene.status();
  const auto revision = CommitInParts(**engine, scene->id(), plan->delta);
  if (!revision.ok()) return revision.status();
  const auto baked = BakeAll(command, *plan, **engine, scene->id(), console, stop);
  if (!baked.ok()) return baked.status();

  const Json summary = {
      {"scene", request.scene.string()}, {"revision", *revision}, {"baked", *baked}};
  if (request.every_polygon) {
    const absl::Status status = WriteText(command.out / "summary.json", JsonText(summary) + "\n");
    if (!status.ok()) return status;
  }
  for (const std::string& note : plan->notes) console.Note(note);
  if (command.json) {
    console.out << JsonText(Json{{"revision", *revision}, {"baked", *baked}}) << '\n';
  } else {
    console.out << "wrote " << baked->size() << (baked->size() == 1 ? " shadow" : " shadows")
                << " to " << command.out.string() << '\n';
  }
  return absl::OkStatus();
}

}  // namespace penumbra
