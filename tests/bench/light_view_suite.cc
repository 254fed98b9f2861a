// Depth maps from a lamp's samples: triangles drawn, against rays by Embree, per view, on scenes of
// other authors and on generated ones: a mesh of two million triangles, and leaves cut out by a
// mask. Rows *_vs_model are what was measured over what render/light_view/depth_method.h expects.

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "render/light_view/auto_depth_source.h"
#include "render/light_view/gl_depth_source.h"
#include "render/light_view/view_fit.h"
#include "render/scene/light_sample.h"
#include "tests/bench/bench.h"
#include "tests/support/rippled_torus.h"
#include "tests/support/scenes_on_floors.h"
#include "tests/support/shapes.h"

namespace penumbra::bench {
namespace {

constexpr uint32_t kViews = 8;
constexpr double kSides[] = {128, 512, 1024};
constexpr double kGlSide = 512;
constexpr int kCpuRuns = 3;

// Views of the lamp's first face from its samples, about `side` pixels wide.
std::vector<LightView> ViewsOf(const Scene& scene, double side) {
  const AreaLight& lamp = *scene.FindLight("lamp");
  const LightFace face = FacesOf(lamp, scene.Bounds()).at(0);
  std::vector<Aabb> boxes;
  for (const auto& [id, instance] : scene.instances()) boxes.push_back(WorldBounds(*instance));
  const double pitch = CenterView(face, boxes, 1e-4)->window.size().x / side;
  std::vector<LightView> views;
  for (const LightSample& sample : SampleLight(lamp, kViews, 1, scene.Bounds().center())) {
    views.push_back(*ViewFrom(face, sample, boxes, pitch));
  }
  return views;
}

void DrawAll(DepthSource& source, std::span<const LightView> views) {
  const auto status = source.Draw(views, {}, [](size_t, DepthMap) { return absl::OkStatus(); });
  if (!status.ok()) std::abort();
}

// Nanoseconds of the processor's time that a view takes on one thread: what the model is of.
double ThreadNs(DepthSource& source, std::span<const LightView> views) {
  std::vector<double> ns;
  for (int run = 0; run < kCpuRuns; ++run) {
    const std::clock_t start = std::clock();
    DrawAll(source, views);
    ns.push_back(1e9 / CLOCKS_PER_SEC * static_cast<double>(std::clock() - start));
  }
  return Median(ns) / static_cast<double>(views.size());
}

void AddModelRows(const std::string& prefix, const Scene& scene, CasterBvhs& bvhs,
                  std::span<const LightView> views, std::vector<Row>& rows) {
  tbb::task_arena one_thread(1);
  RayDepthSource rays(bvhs.Of(scene), one_thread);
  RasterDepthSource raster(scene, one_thread);
  DrawAll(raster, views.first(1));  // places the casters
  const CasterSizes sizes(scene);
  double raster_ns = 0, rays_ns = 0;
  for (const LightView& view : views) {
    raster_ns += RasterNs(sizes.WorkOf(view)) / static_cast<double>(views.size());
    rays_ns += RaysNs(sizes.WorkOf(view)) / static_cast<double>(views.size());
  }
  const double raster_measured = ThreadNs(raster, views), rays_measured = ThreadNs(rays, views);
  const DepthWork work = sizes.WorkOf(views[0]);
  rows.insert(rows.end(), {{prefix + "pixels", work.pixels, "1"},
                           {prefix + "casters", work.casters, "1"},
                           {prefix + "triangles", work.triangles, "1"},
                           {prefix + "masked_triangles", work.masked_triangles, "1"},
                           {prefix + "covered", work.covered, "1"},
                           {prefix + "filled", work.filled, "1"},
                           {prefix + "masked_filled", work.masked_filled, "1"},
                           {prefix + "raster_cpu_per_view", 1e-6 * raster_measured, "ms"},
                           {prefix + "rays_cpu_per_view", 1e-6 * rays_measured, "ms"},
                           {prefix + "raster_vs_model", raster_measured / raster_ns, "x"},
                           {prefix + "rays_vs_model", rays_measured / rays_ns, "x"}});
}

void AddRows(const std::string& name, const Scene& scene, double side, const BenchOptions& options,
             std::vector<Row>& rows) {
  tbb::task_arena arena(options.threads);
  CasterBvhs bvhs;
  RayDepthSource rays(bvhs.Of(scene), arena);
  RasterDepthSource raster(scene, arena);
  const auto views = ViewsOf(scene, side);
  const Duel duel = Interleave(
      0.2 * options.min_seconds, [&] { DrawAll(raster, views); }, [&] { DrawAll(rays, views); });
  const std::string prefix =
      "light_view." + name + "." + std::to_string(static_cast<int>(side)) + ".";
  rows.insert(rows.end(), {{prefix + "raster_per_view", duel.OursMs() / kViews, "ms"},
                           {prefix + "rays_per_view", duel.PeersMs() / kViews, "ms"},
                           {prefix + "raster_speedup_vs_rays", duel.Speedup(), "x"}});
  AddModelRows(prefix, scene, bvhs, views, rows);
}

// By GL's first device, which may be a software device.
void AddGlRows(const std::string& name, const Scene& scene, gl::Context& context,
               const BenchOptions& options, std::vector<Row>& rows) {
  tbb::task_arena arena(options.threads);
  CasterBvhs bvhs;
  AutoDepthSource cpu(scene, bvhs, arena);
  GlDepthSource by_gl(scene, context, "gl");
  const auto views = ViewsOf(scene, kGlSide);
  const Duel duel = Interleave(
      0.2 * options.min_seconds, [&] { DrawAll(by_gl, views); }, [&] { DrawAll(cpu, views); });
  const std::string prefix = "light_view." + name + ".";
  rows.insert(rows.end(), {{prefix + "gl_per_view", duel.OursMs() / kViews, "ms"},
                           {prefix + "gl_speedup_vs_cpu", duel.Speedup(), "x"}});
}

// Squares of 6 cm, turned every way, in a ball of 2 m, each with a round leaf cut out of it.
Instance Leaves(int count) {
  constexpr uint32_t kTexels = 64;
  std::mt19937 random(2000);
  std::uniform_real_distribution<float> uniform(-1, 1);
  const auto direction = [&] {
    return glm::normalize(Vec3(uniform(random), uniform(random), 0.5f));
  };
  MeshGeometry mesh;
  for (int i = 0; i < count; ++i) {
    const Vec3 normal = direction(), u = 0.03f * glm::normalize(glm::cross(normal, Vec3(0, 1, 0)));
    const Vec3 v = 0.03f * glm::normalize(glm::cross(normal, u));
    const Vec3 at = std::cbrt(std::abs(uniform(random))) * direction();
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), {at - u - v, at + u - v, at + u + v, at - u + v});
    mesh.uvs.insert(mesh.uvs.end(), {{0, 0}, {1, 0}, {1, 1}, {0, 1}});
    for (const uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(first + k);
  }
  std::vector<uint8_t> alpha;
  for (uint32_t t = 0; t < kTexels * kTexels; ++t) {
    const Vec2 off = (Vec2(t % kTexels, t / kTexels) + 0.5f) / static_cast<float>(kTexels) - 0.5f;
    alpha.push_back(glm::length(off) < 0.5f ? 255 : 0);
  }
  return {.id = "leaves",
          .mesh = testing::MeshOf(std::move(mesh)),
          .alpha_mask = AlphaMask::Create(kTexels, kTexels, std::move(alpha)).value()};
}

// The instances of `path` on a floor, or nothing, with the reason on stderr.
std::shared_ptr<const Scene> Load(const testing::SceneFile& file) {
  const auto folder = testing::ScenesFolder(PENUMBRA_DEFAULT_SCENES);
  auto scene = testing::LoadOnFloor(folder / file.path);
  if (scene.ok()) return *std::move(scene);
  std::fprintf(stderr, "light_view.%s: left out, %s\n", file.name,
               std::string(scene.status().message()).c_str());
  return nullptr;
}

}  // namespace

std::vector<Row> LightViewSuite(const BenchOptions& options) {
  std::vector<Row> rows;
  const auto context = gl::Context::Create();
  if (context.ok()) {
    std::fprintf(stderr, "light_view: gl is %s\n", (*context)->info().renderer.c_str());
  }
  for (const testing::SceneFile& file : testing::kScenesOnFloors) {
    const auto scene = Load(file);
    if (!scene) continue;
    for (const double side : kSides) AddRows(file.name, *scene, side, options, rows);
    if (context.ok()) AddGlRows(file.name, *scene, **context, options, rows);
  }
  const auto torus = testing::MeshOf(testing::RippledTorus(2000, 500));
  const auto scene = testing::OnFloor({{.id = "torus", .mesh = torus}});
  for (const double side : kSides) AddRows("torus_2m", *scene, side, options, rows);
  const auto leaves = testing::OnFloor({Leaves(20'000)});
  for (const double side : kSides) AddRows("leaves_20k", *leaves, side, options, rows);
  return rows;
}

}  // namespace penumbra::bench
