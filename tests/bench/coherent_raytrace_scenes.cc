#include "tests/bench/coherent_raytrace_scenes.h"

#include <cstdio>
#include <filesystem>

#include "client/cli/shadow_plan.h"
#include "client/import/import_scene.h"
#include "tests/bench/bench.h"
#include "tests/support/scenes_folder.h"

namespace penumbra::bench {
namespace {

struct Model {
  const char* name;
  const char* file;
  bool has_floor;      // of its own
  float towards_head;  // in −x, in the light's widths
};

constexpr Model kModels[] = {
    {"garden", "bridge-garden/scene.glb", true, 0.0f},
    {"flower", "flower/flower_blue.glb", false, 0.0f},
    {"plants", "plants-unclear-licence/plants.gltf", false, 0.0f},
    {"dragon", "stanford-dragon-res2/dragon_vrip_res2.ply", false, 0.7f},
};

LitModel Lit(const Model& model, const std::filesystem::path& file) {
  const ImportedScene imported = OrDie(ImportScene(file));
  const Aabb bounds = Bounds(imported);
  SceneDelta delta;
  delta.upsert_instances = imported.instances;
  if (!model.has_floor) {
    const Parallelogram floor = FloorUnder(bounds);
    MeshGeometry geometry{
        .positions = {floor.origin, floor.At({1, 0}), floor.At({1, 1}), floor.At({0, 1})},
        .indices = {0, 1, 2, 0, 2, 3}};
    delta.upsert_instances.push_back(
        {.id = "bench-floor", .mesh = OrDie(Mesh::Create(std::move(geometry)))});
  }
  AreaLight light = LightAbove(bounds);
  auto& rectangle = std::get<RectangleLight>(light.shape);
  rectangle.two_sided = false;
  rectangle.corner -= model.towards_head * rectangle.edge_u;
  delta.upsert_lights = {light};
  return {.name = model.name,
          .scene = OrDie(Scene::Empty(model.name)->Apply(delta)),
          .light = light,
          .camera = FrameScene(bounds, 1.0f)};
}

}  // namespace

std::vector<LitModel> LitModels() {
  std::vector<LitModel> models;
  const auto folder = testing::ScenesFolder("shared/scenes");
  for (const Model& model : kModels) {
    const auto file = folder / model.file;
    if (std::filesystem::exists(file)) {
      models.push_back(Lit(model, file));
    } else {
      std::fprintf(stderr, "penumbra_bench: no %s; set PENUMBRA_SCENES\n", file.c_str());
    }
  }
  return models;
}

}  // namespace penumbra::bench
