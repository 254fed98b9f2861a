// How the time for the textures of all polygons of a scene grows with their number.
//
// Each of n polygons shadows the others and receives their shadows: n textures. Polygons are
// squares of one size, anywhere in a cube and turned any way; one lamp of fixed size hangs over the
// cube. In the family `growth` the cube's volume grows with n, so that a texture's neighbourhood
// stays the same and its light's way gets longer; in `growth_dense` the cube stays as it is, ever
// more polygons lie between each receiver and the lamp, and no culling can help.

#include <cmath>
#include <cstdio>
#include <random>
#include <string>

#include "render/math/parallel_for.h"
#include "render/technique/technique.h"
#include "tests/bench/bench.h"
#include "tests/support/shapes.h"

namespace penumbra::bench {
namespace {

constexpr uint32_t kTexels = 32;
constexpr uint32_t kSamples = 16;
constexpr float kPolygonSide = 1;  // m
constexpr float kRoomForEach = 3;  // m³: a third of the neighbourhood is polygons

// `side` of the cube in metres.
std::shared_ptr<const Scene> Polygons(int count, float side) {
  std::mt19937 random(1997);
  std::uniform_real_distribution<float> uniform(-1, 1);
  const auto direction = [&] {
    for (;;) {
      const Vec3 p(uniform(random), uniform(random), uniform(random));
      if (glm::length(p) > 0.1f && glm::length(p) < 1) return glm::normalize(p);
    }
  };
  SceneDelta delta;
  delta.upsert_lights = {{.id = "lamp",
                          .shape = RectangleLight{.corner = Vec3(-0.5f, 0.5f * side + 1, -0.5f),
                                                  .edge_u = Vec3(1, 0, 0),
                                                  .edge_v = Vec3(0, 0, 1)}}};
  const auto square = testing::MeshOf(testing::UnitSquareGeometry());
  for (int i = 0; i < count; ++i) {
    const Vec3 normal = direction();
    const Vec3 u = glm::normalize(glm::cross(normal, direction()));
    const Vec3 v = glm::cross(u, normal), half(0.5f * kPolygonSide);
    const Vec3 place = 0.5f * side * Vec3(uniform(random), uniform(random), uniform(random));
    const std::string id = "polygon" + std::to_string(i);
    delta.upsert_instances.push_back(
        {.id = id, .mesh = square, .world_from_mesh = Affine(half * u, normal, half * -v, place)});
    delta.upsert_receivers.push_back({.id = id,
                                      .shape = PlanarInstance{.instance_id = id},
                                      .width = kTexels,
                                      .height = kTexels});
  }
  SceneLimits limits;
  limits.max_receivers = static_cast<uint64_t>(count);
  return Scene::Empty("growth")->Apply(delta, limits).value();
}

// Milliseconds for the textures of all polygons, receivers shared out among the threads. The
// hierarchy over the polygons is made anew, by a commit that changes one.
double AllTexturesMs(const Scene& scene, int threads) {
  const auto edited = scene.Apply({.upsert_instances = {*scene.instances().begin()->second}},
                                  {.max_receivers = 1'000'000});
  tbb::task_arena arena(threads);
  std::vector<ArtifactSpec> specs;
  for (const auto& [id, receiver] : scene.receivers()) {
    specs.push_back({SoftTextureParams{.samples = kSamples}, "lamp", id});
  }
  const double start = NowMs();
  RunIn(arena, [&] {
    ParallelFor(specs.size(), [&](size_t i) {
      tbb::task_arena own(1);
      (void)TechniqueFor(specs[i].params).Compute(**edited, specs[i], {.arena = own});
    });
  });
  return NowMs() - start;
}

// The exponent e of the least-squares fit t = c nᵉ.
double FittedExponent(const std::vector<std::pair<double, double>>& times) {
  double sum_x = 0, sum_y = 0, sum_xx = 0, sum_xy = 0;
  for (const auto& [n, t] : times) {
    const double x = std::log(n), y = std::log(t);
    sum_x += x;
    sum_y += y;
    sum_xx += x * x;
    sum_xy += x * y;
  }
  const auto count = static_cast<double>(times.size());
  return (count * sum_xy - sum_x * sum_y) / (count * sum_xx - sum_x * sum_x);
}

std::vector<Row> Family(const std::string& name, const std::vector<int>& sizes, bool is_dense,
                        const BenchOptions& options) {
  std::vector<Row> rows;
  std::vector<std::pair<double, double>> times;
  const std::string prefix = "soft_texture." + name + ".";
  for (const int n : sizes) {
    const auto room = static_cast<float>(is_dense ? sizes.front() : n);
    const auto scene = Polygons(n, std::cbrt(kRoomForEach * room));
    std::vector<double> runs;
    const double end = NowMs() + 250 * options.min_seconds;
    do {
      runs.push_back(AllTexturesMs(*scene, options.threads));
    } while (NowMs() < end);
    times.emplace_back(n, Median(runs));
    rows.push_back({prefix + "all_textures_" + std::to_string(n), Median(runs), "ms"});
  }
  rows.push_back({prefix + "exponent", FittedExponent(times), "1"});
  return rows;
}

}  // namespace

std::vector<Row> GrowthSuite(const BenchOptions& options) {
  std::vector<Row> rows = Family("growth", {100, 316, 1000, 3162, 10000}, false, options);
  const std::vector<Row> dense = Family("growth_dense", {100, 316, 1000, 3162}, true, options);
  rows.insert(rows.end(), dense.begin(), dense.end());
  return rows;
}

}  // namespace penumbra::bench
