// soft_texture against Embree: the same light samples seen from the same texels on as many threads.
//
// Ours is a whole Compute(): preparing the occluders, drawing, counting, making the artifact.
// Embree's is tracing alone, in its fastest form for these rays, its hierarchy built beforehand:
// what a ray tracer has to pay for an edit is left out in its favour.

#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <random>

#include "client/import/import_scene.h"
#include "render/reference/ray_visibility.h"
#include "render/technique/soft_texture/coverage_kernel.h"
#include "render/technique/technique.h"
#include "tests/bench/bench.h"
#include "tests/bench/studio.h"
#include "tests/support/rippled_torus.h"
#include "tests/support/shapes.h"

namespace penumbra::bench {
namespace {

constexpr uint32_t kTexels = 256;
constexpr uint32_t kSamples = 64;

// The mesh of `ply`, or the torus, at the middle of the floor and 4 m wide.
SceneDelta Dragon(const std::string& ply) {
  SceneDelta delta = Studio(kTexels);
  if (ply.empty()) {
    delta.upsert_instances = {
        {.id = "torus", .mesh = testing::MeshOf(testing::RippledTorus(500, 200))}};
  } else {
    auto imported = ImportScene(ply);
    if (!imported.ok()) {
      std::fprintf(stderr, "penumbra_bench: --ply: %s\n",
                   std::string(imported.status().message()).c_str());
      std::exit(1);
    }
    delta.upsert_instances = std::move(imported->instances);
  }
  Aabb bounds;
  for (const Instance& instance : delta.upsert_instances) bounds.Add(WorldBounds(instance));
  const float scale = 4 / std::max(bounds.extent().x, bounds.extent().z);
  for (Instance& instance : delta.upsert_instances) {
    instance.world_from_mesh =
        testing::Placed(Vec3(0, 0.5f - scale * bounds.min.y, 0) -
                            scale * Vec3(bounds.center().x, 0, bounds.center().z),
                        scale);
  }
  return delta;
}

// One case: both sides' medians, their ratio, and the share of texel-samples on which they
// disagree.
std::vector<Row> RunCase(const std::string& name, const SceneDelta& delta,
                         const BenchOptions& options) {
  const auto scene = Scene::Empty("bench")->Apply(delta).value();
  const ArtifactSpec spec{SoftTextureParams{.samples = kSamples}, "lamp", "floor"};
  tbb::task_arena arena(options.threads);
  const ComputeContext context{
      .arena = arena, .gl = nullptr, .stop = {}, .progress = {}, .now_ms = {}};
  const Technique& technique = TechniqueFor(spec.params);
  const Artifact artifact = technique.Compute(*scene, spec, context).value();
  const auto& texture = std::get<SoftShadowTexture>(artifact.payload);
  const double offset = std::atof(artifact.header.parameters.at("surface_offset_m").c_str());

  const RayVisibility rays(*scene, RayVisibility::Intersector::kFast);
  VisibilityMap traced;
  const Duel duel = Interleave(
      options.min_seconds, [&] { (void)technique.Compute(*scene, spec, context); },
      [&] {
        traced = rays.Counts(texture.receiver, artifact.header.light_samples, offset, arena);
      });
  double differing = 0;
  for (size_t i = 0; i < traced.counts.size(); ++i) {
    differing += std::abs(traced.counts[i] - texture.visibility.counts[i]);
  }
  const double texel_samples = static_cast<double>(traced.counts.size()) * kSamples;
  const std::string prefix = "soft_texture." + name + ".";
  return {{prefix + "triangles", static_cast<double>(rays.triangle_count()), "1"},
          {prefix + "median", duel.OursMs(), "ms"},
          {prefix + "texel_samples_per_s", texel_samples / duel.OursMs() * 1e3, "1/s"},
          {prefix + "embree_median", duel.PeersMs(), "ms"},
          {prefix + "embree_rays_per_s", texel_samples / duel.PeersMs() * 1e3, "1/s"},
          {prefix + "speedup_vs_embree", duel.Speedup(), "x"},
          {prefix + "differing_fraction", differing / texel_samples, "1"}};
}

// Moving one of the boxes of `delta` to and fro, the other occluders' shadows being kept, against
// rays through the whole scene.
std::vector<Row> RunIncremental(const std::string& name, const SceneDelta& delta,
                                const BenchOptions& options) {
  const auto before = Scene::Empty("bench")->Apply(delta).value();
  std::vector<std::shared_ptr<const Scene>> scenes;
  for (const float x : {0.1f, 0.2f}) {
    Instance box = *before->FindInstance("box7");
    box.world_from_mesh[3] += Vec3(x, 0, 0);
    scenes.push_back(before->Apply({.upsert_instances = {box}}).value());
  }
  const ArtifactSpec spec{SoftTextureParams{.samples = kSamples}, "lamp", "floor"};
  tbb::task_arena arena(options.threads);
  MemoryBudget budget(size_t{64} << 20);
  TechniqueMemory memory{budget, nullptr};
  const ComputeContext context{.arena = arena, .memory = &memory};
  const Technique& technique = TechniqueFor(spec.params);
  for (const auto& scene : {before, scenes[0], scenes[1]}) {
    (void)technique.Compute(*scene, spec, context);
  }
  size_t turn = 0;
  const auto edit = [&] { return technique.Compute(*scenes[++turn % 2], spec, context).value(); };
  const Artifact artifact = edit();
  const double offset = std::atof(artifact.header.parameters.at("surface_offset_m").c_str());
  const auto& texture = std::get<SoftShadowTexture>(artifact.payload);
  const RayVisibility rays(*scenes[turn % 2], RayVisibility::Intersector::kFast);
  const Duel duel = Interleave(
      options.min_seconds, [&] { (void)edit(); },
      [&] { rays.Counts(texture.receiver, artifact.header.light_samples, offset, arena); });
  const std::string prefix = "soft_texture." + name + ".";
  return {{prefix + "median", duel.OursMs(), "ms"},
          {prefix + "embree_median", duel.PeersMs(), "ms"},
          {prefix + "speedup_vs_embree", duel.Speedup(), "x"}};
}

}  // namespace

std::vector<Row> SoftTextureSuite(const BenchOptions& options) {
  std::fprintf(stderr, "soft_texture: kernels for %s, %d threads\n", KernelTargetName(),
               options.threads);
  std::vector<Row> rows;
  for (const auto& [name, delta] :
       {std::pair{"herf256", Boxes(84, kTexels)}, std::pair{"boxes1000", Boxes(1000, kTexels)},
        std::pair{"dragon", Dragon(options.ply)}}) {
    std::vector<Row> more = RunCase(name, delta, options);
    rows.insert(rows.end(), more.begin(), more.end());
  }
  for (const std::vector<Row>& more :
       {RunIncremental("herf256_incremental", Boxes(84, kTexels), options),
        SilhouetteSuite(options), GrowthSuite(options), DragRows(options)}) {
    rows.insert(rows.end(), more.begin(), more.end());
  }
  return rows;
}

}  // namespace penumbra::bench
