// shadow_width: distance transforms against OpenCV's, penumbras against those of the light, and
// what a map costs beside the depth map that it starts from.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "render/light_view/auto_depth_source.h"
#include "render/light_view/light_face.h"
#include "render/light_view/view_fit.h"
#include "render/technique/shadow_width/shadow_width.h"
#include "tests/bench/bench.h"
#include "tests/support/scenes_folder.h"
#include "tests/support/scenes_on_floors.h"
#include "tests/support/straight_edge.h"

namespace penumbra::bench {
namespace {

using penumbra::testing::StraightEdge;

constexpr double kHeights[] = {0.4, 0.6, 0.8, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5};

struct NamedLight {
  const char* name;
  LightShape shape;
};

// All four metres over the floor, but for the sun.
std::vector<NamedLight> Lights() {
  return {{"rectangle",
           RectangleLight{
               .corner = {-0.3f, 4, -0.15f}, .edge_u = {0.6f, 0, 0}, .edge_v = {0, 0, 0.3f}}},
          {"disk", DiskLight{.center = {0, 4, 0}, .normal = {0, -1, 0}, .radius = 0.3f}},
          {"sphere", SphereLight{.center = {0.3f, 4, 0.2f}, .radius = 0.25f}},
          {"sun", DistantLight{.to_light = {0.1f, 1, 0.05f}, .angular_diameter = 0.15f}}};
}

Artifact MapOf(const Scene& scene, const std::string& light_id, uint32_t resolution,
               tbb::task_arena& arena) {
  return OrDie(ShadowWidth().Compute(scene, {ShadowWidthParams{.resolution = resolution}, light_id},
                                     {.arena = arena}));
}

// How wide the penumbra behind a straight edge is, ours and the light's, over the edge's height,
// and the ratio that is furthest from 1.
std::vector<Row> PenumbraRows(tbb::task_arena& arena) {
  std::vector<Row> rows;
  for (const NamedLight& light : Lights()) {
    double worst = 1;
    for (const double height : kHeights) {
      for (const double angle : {0.0, 0.25 * std::numbers::pi, 0.5 * std::numbers::pi}) {
        const StraightEdge edge{
            .light = {.id = "light", .shape = light.shape}, .height = height, .angle = angle};
        const Artifact map = MapOf(*edge.MakeScene(), "light", 2048, arena);
        const auto ours = testing::PenumbraWidth(edge, map);
        const double lights = testing::TruePenumbraWidth(edge);
        const double ratio = ours.value_or(0) / lights;  // 0: no penumbra was found
        if (std::abs(std::log(ratio)) > std::abs(std::log(worst))) worst = ratio;
        if (angle != 0) continue;
        const std::string name =
            absl::StrFormat("penumbra.%s.at_%03d_cm.", light.name, std::lround(100 * height));
        rows.push_back({name + "width", ours.value_or(0), "m"});
        rows.push_back({name + "width_of_light", lights, "m"});
      }
    }
    rows.push_back({absl::StrCat("penumbra.", light.name, ".worst_ratio"), worst, "x"});
  }
  return rows;
}

// The whole map beside the depth maps of the same views by the quicker source.
std::vector<Row> CostRows(const BenchOptions& options, tbb::task_arena& arena) {
  std::vector<Row> rows;
  for (const testing::SceneFile& file : testing::kScenesOnFloors) {
    const auto scene =
        testing::LoadOnFloor(testing::ScenesFolder(PENUMBRA_DEFAULT_SCENES) / file.path);
    if (!scene.ok()) {
      std::fprintf(stderr, "penumbra_bench: %s is left out: %s\n", file.name,
                   std::string(scene.status().message()).c_str());
      continue;
    }
    const std::string light_id = (*scene)->lights().begin()->first;
    CasterBvhs bvhs;
    AutoDepthSource source(**scene, bvhs, arena);
    std::vector<LightView> views;
    const Aabb bounds = (*scene)->Bounds();
    for (const LightFace& face : FacesOf(*(*scene)->FindLight(light_id), bounds)) {
      const DVec2 size = face.window.size();
      if (auto view = CenterView(face, {&bounds, 1}, std::max(size.x, size.y) / 512)) {
        views.push_back(*view);
      }
    }
    MemoryBudget budget(size_t{1} << 32);
    TechniqueMemory memory{.budget = budget};
    const Duel duel = Interleave(
        options.min_seconds,
        [&] {
          (void)OrDie(ShadowWidth().Compute(**scene, {ShadowWidthParams{}, light_id},
                                            {.arena = arena, .memory = &memory}));
        },
        [&] {
          (void)source.Draw(views, {}, [](size_t, const DepthMap&) { return absl::OkStatus(); });
        });
    rows.push_back({absl::StrCat(file.name, ".map"), duel.OursMs(), "ms"});
    rows.push_back({absl::StrCat(file.name, ".cost_vs_depth_map"), 1 / duel.Speedup(), "x"});
  }
  return rows;
}

}  // namespace

std::vector<Row> ShadowWidthSuite(const BenchOptions& options) {
  tbb::task_arena arena(options.threads);
  std::vector<Row> rows = DistanceSuite(options);
  for (const auto& more : {PenumbraRows(arena), CostRows(options, arena)}) {
    rows.insert(rows.end(), more.begin(), more.end());
  }
  return rows;
}

}  // namespace penumbra::bench
