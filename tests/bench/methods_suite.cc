// Which method draws what fastest, and how near `auto` comes to it. One thread, whole computations.
// Times are the least of several runs, methods taking turns, so that what disturbs the machine
// disturbs none of them for long.

#include <array>
#include <string>

#include "render/technique/technique.h"
#include "tests/bench/bench.h"
#include "tests/support/random_scene.h"
#include "tests/support/rippled_torus.h"
#include "tests/support/shapes.h"

namespace penumbra::bench {
namespace {

constexpr uint32_t kSamples = 16;
constexpr std::array<VisibilityMethod, 4> kMethods = {
    VisibilityMethod::kAuto, VisibilityMethod::kCoverage, VisibilityMethod::kEdgeFlag,
    VisibilityMethod::kSilhouette};

SceneDelta Studio(uint32_t texels) {
  SceneDelta delta;
  delta.upsert_receivers = {testing::FloorReceiver("floor", 10, texels)};
  delta.upsert_lights = {
      {.id = "lamp",
       .shape = RectangleLight{
           .corner = Vec3(-1, 8, -1), .edge_u = Vec3(2, 0, 0), .edge_v = Vec3(0, 0, 2)}}};
  return delta;
}

// `count` copies of `mesh`, turned any way, between floor and lamp.
SceneDelta Scattered(const std::shared_ptr<const Mesh>& mesh, int count, float size,
                     uint32_t texels) {
  SceneDelta delta = Studio(texels);
  testing::Dice dice(7);
  for (int i = 0; i < count; ++i) {
    const Vec3 x = dice.Direction(), y = glm::normalize(glm::cross(x, dice.Direction()));
    const Vec3 place(dice.Between(-3, 3), dice.Between(2, 4), dice.Between(-3, 3));
    delta.upsert_instances.push_back(
        {.id = "mesh" + std::to_string(i),
         .mesh = mesh,
         .world_from_mesh = Affine(size * x, size * y, size * glm::cross(x, y), place)});
  }
  return delta;
}

// Triangles of `size` metres, each on its own.
std::shared_ptr<const Mesh> Loose(int count, float size) {
  testing::Dice dice(11);
  MeshGeometry soup;
  for (int t = 0; t < count; ++t) {
    const Vec3 at = dice.InCube(2);
    for (int k = 0; k < 3; ++k) {
      soup.positions.push_back(at + size * dice.Direction());
      soup.indices.push_back(static_cast<uint32_t>(3 * t + k));
    }
  }
  return testing::MeshOf(std::move(soup));
}

std::vector<Row> RunCase(const std::string& name, const SceneDelta& delta,
                         const BenchOptions& options) {
  const auto scene = Scene::Empty("bench")->Apply(delta).value();
  tbb::task_arena arena(1);
  std::array<double, kMethods.size()> least_ms;
  least_ms.fill(1e30);
  const double end = NowMs() + 250 * options.min_seconds;
  for (int round = 0; round < 4 || NowMs() < end; ++round) {
    for (size_t m = 0; m < kMethods.size(); ++m) {
      const ArtifactSpec spec{SoftTextureParams{.samples = kSamples, .method = kMethods[m]}, "lamp",
                              "floor"};
      const double start = NowMs();
      (void)TechniqueFor(spec.params).Compute(*scene, spec, {.arena = arena});
      // The first prepares the mesh.
      if (round > 0) least_ms[m] = std::min(least_ms[m], NowMs() - start);
    }
  }
  const std::string prefix = "methods." + name + ".";
  std::vector<Row> rows;
  for (size_t m = 0; m < kMethods.size(); ++m) {
    rows.push_back({prefix + std::string(kVisibilityMethodNames[m]), least_ms[m], "ms"});
  }
  const double best = *std::min_element(least_ms.begin() + 1, least_ms.end());
  rows.push_back({prefix + "auto_vs_best", least_ms[0] / best, "x"});
  return rows;
}

}  // namespace

std::vector<Row> MethodsSuite(const BenchOptions& options) {
  std::vector<Row> rows;
  const auto run = [&](const std::string& name, const SceneDelta& delta) {
    const std::vector<Row> more = RunCase(name, delta, options);
    rows.insert(rows.end(), more.begin(), more.end());
  };
  for (const uint32_t texels : {64u, 256u, 1024u}) {
    const std::string at = "_at_" + std::to_string(texels);
    run("boxes_84" + at, Scattered(testing::MeshOf(testing::UnitBoxGeometry()), 84, 0.2f, texels));
    run("big_triangles_200" + at, Scattered(Loose(200, 2), 1, 1, texels));
    for (const auto& [across, faces] :
         {std::pair{5u, "400"}, std::pair{10u, "1600"}, std::pair{25u, "10000"},
          std::pair{50u, "40000"}, std::pair{100u, "160000"}}) {
      const auto torus = testing::MeshOf(testing::RippledTorus(8 * across, across));
      run("torus_" + std::string(faces) + at, Scattered(torus, 1, 1.5f, texels));
    }
  }
  run("tori_64_of_1600_at_256",
      Scattered(testing::MeshOf(testing::RippledTorus(80, 10)), 64, 0.3f, 256));
  return rows;
}

}  // namespace penumbra::bench
