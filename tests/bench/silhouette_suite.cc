// Finding the outlines that 64 light samples see: every edge looked at for each, against the
// hierarchies of clusters of edges and of groups of samples, as a computation uses them, on one
// thread.
//
// Shares are of a whole Compute(): as it is, and with every edge looked at instead.

#include <cstdio>
#include <cstdlib>
#include <string>

#include "client/import/import_scene.h"
#include "render/math/box_tree.h"
#include "render/scene/light_sample.h"
#include "render/technique/technique.h"
#include "tests/bench/bench.h"
#include "tests/support/rippled_torus.h"
#include "tests/support/shapes.h"

namespace penumbra::bench {
namespace {

constexpr uint32_t kSamples = 64;
constexpr uint32_t kGroup = 8;
constexpr uint32_t kManySamples = 512;

// `mesh` 4 m wide, half a metre over the middle of a floor of 10 m, under a lamp of 2 m: the scene
// of soft_texture.dragon.
std::shared_ptr<const Scene> SceneWith(std::shared_ptr<const Mesh> mesh) {
  const Aabb& box = mesh->bounds();
  const float scale = 4 / std::max(box.extent().x, box.extent().z);
  const Vec3 place =
      Vec3(0, 0.5f - scale * box.min.y, 0) - scale * Vec3(box.center().x, 0, box.center().z);
  SceneDelta delta;
  delta.upsert_receivers = {testing::FloorReceiver("floor", 10, 256)};
  delta.upsert_lights = {
      {.id = "lamp",
       .shape = RectangleLight{
           .corner = Vec3(-1, 8, -1), .edge_u = Vec3(2, 0, 0), .edge_v = Vec3(0, 0, 2)}}};
  delta.upsert_instances = {
      {.id = "mesh", .mesh = std::move(mesh), .world_from_mesh = testing::Placed(place, scale)}};
  return Scene::Empty("bench")->Apply(delta).value();
}

// The light samples as the mesh sees them, neighbours one after another.
std::vector<DVec4> ViewpointsOf(const Scene& scene) {
  const Affine& m = scene.FindInstance("mesh")->world_from_mesh;
  const auto samples = SampleLight(*scene.FindLight("lamp"), kSamples, 1, Vec3(0.0f));
  std::vector<Aabb> places;
  for (const LightSample& sample : samples) places.push_back({sample.point, sample.point});
  std::vector<DVec4> viewpoints;
  BoxTree(places, kGroup).VisitLeaves([&](std::span<const uint32_t> leaf) {
    for (const uint32_t s : leaf) {
      viewpoints.emplace_back((DVec3(samples[s].point) - DVec3(m[3])) / double{m[0].x}, 1.0);
    }
  });
  return viewpoints;
}

// Ways to find the outlines of one mesh from all views.
struct Finder {
  const SilhouetteEdges& edges;
  const std::vector<DVec4> views;
  std::vector<SilhouetteList> lists{kGroup};
  size_t found = 0;  // edges, over all views, by the last that ran

  void Count(std::span<SilhouetteList> filled) {
    for (SilhouetteList& list : filled) {
      found += list.count;
      list.Clear();
    }
  }
  void OneByOne() {
    found = 0;
    for (const DVec4 view : views) {
      edges.Find(view, lists[0]);
      Count({lists.data(), 1});
    }
  }
  void ByGroups() {
    found = 0;
    const SilhouetteEdges seen = edges.SeenFrom(ViewBall::Around(views));
    for (size_t v = 0; v < views.size(); v += kGroup) {
      seen.FindEach(std::span(views).subspan(v, kGroup), lists);
      Count(lists);
    }
  }
};

// Outlines that eight neighbours share, with what telling their error takes, for many samples.
std::vector<Row> RunReuse(const std::string& prefix, const Scene& scene,
                          const BenchOptions& options) {
  tbb::task_arena arena(1);
  std::string error;
  const auto compute = [&](uint32_t reuse) {
    const ArtifactSpec spec{SoftTextureParams{.samples = kManySamples,
                                              .method = VisibilityMethod::kSilhouette,
                                              .silhouette_reuse = reuse},
                            "lamp", "floor"};
    const auto artifact = TechniqueFor(spec.params).Compute(scene, spec, {.arena = arena});
    if (reuse > 1) error = artifact->header.parameters.at("silhouette_reuse_error");
  };
  const Duel reuse = Interleave(
      0.2 * options.min_seconds, [&] { compute(kGroup); }, [&] { compute(1); });
  return {{prefix + "reuse_speedup_vs_exact", reuse.Speedup(), "x"},
          {prefix + "reuse_error", std::stod(error), "1"}};
}

std::vector<Row> RunCase(const std::string& name, std::shared_ptr<const Mesh> mesh,
                         const BenchOptions& options) {
  const double start = NowMs();
  const SilhouetteEdges& edges = mesh->silhouette_edges();
  const double prepared_ms = NowMs() - start;
  const auto scene = SceneWith(mesh);
  Finder finder{.edges = edges, .views = ViewpointsOf(*scene)};
  const auto by_groups = [&] { finder.ByGroups(); };
  const auto one_by_one = [&] { finder.OneByOne(); };
  const ArtifactSpec spec{
      SoftTextureParams{.samples = kSamples, .method = VisibilityMethod::kSilhouette}, "lamp",
      "floor"};
  tbb::task_arena arena(1);
  const Duel duel = Interleave(0.4 * options.min_seconds, by_groups, one_by_one);
  const auto found = static_cast<double>(finder.found);
  const Duel share = Interleave(0.4 * options.min_seconds, by_groups, [&] {
    (void)TechniqueFor(spec.params).Compute(*scene, spec, {.arena = arena});
  });
  const double compute = share.PeersMs(), finding = share.OursMs(), flat = duel.PeersMs();
  const double all = static_cast<double>(edges.shared_edge_count() + edges.border_edge_count());
  const double faces = static_cast<double>(mesh->triangle_count());
  const std::string prefix = "soft_texture." + name + ".";
  std::vector<Row> rows = RunReuse(prefix, *scene, options);
  rows.insert(rows.end(),
              {{prefix + "faces", faces, "1"},
               {prefix + "eliminated_fraction", 1 - found / kSamples / all, "1"},
               {prefix + "flat_per_sample", flat / kSamples, "ms"},
               {prefix + "hierarchical_per_sample", duel.OursMs() / kSamples, "ms"},
               {prefix + "speedup_vs_flat", duel.Speedup(), "x"},
               {prefix + "find_share_flat", flat / (compute - finding + flat), "1"},
               {prefix + "find_share_hierarchical", finding / compute, "1"},
               {prefix + "prepare_vs_compute", prepared_ms / compute, "x"},
               {prefix + "bytes_per_face", static_cast<double>(edges.bytes()) / faces, "B"}});
  return rows;
}

}  // namespace

std::vector<Row> SilhouetteSuite(const BenchOptions& options) {
  std::vector<Row> rows;
  const auto run = [&](const std::string& name, std::shared_ptr<const Mesh> mesh) {
    const std::vector<Row> more = RunCase(name, std::move(mesh), options);
    rows.insert(rows.end(), more.begin(), more.end());
  };
  run("silhouette_5k", testing::MeshOf(testing::RippledTorus(100, 25)));
  run("silhouette_50k", testing::MeshOf(testing::RippledTorus(250, 100)));
  run("silhouette_200k", testing::MeshOf(testing::RippledTorus(500, 200)));
  if (options.ply.empty()) return rows;
  const auto imported = ImportScene(options.ply);
  if (!imported.ok() || imported->instances.empty()) {
    std::fprintf(stderr, "penumbra_bench: --ply: %s\n",
                 std::string(imported.status().message()).c_str());
    std::exit(1);
  }
  run("silhouette_ply", imported->instances.front().mesh);
  return rows;
}

}  // namespace penumbra::bench
