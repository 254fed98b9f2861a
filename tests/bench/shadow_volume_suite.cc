// Shadow volumes from depth maps: what McCool's two tables have, on four scenes like his and a
// harder one; how the drawn shadow differs from rays'; and what rebuilding costs against drawing
// the map. All of 1,000 random rotations with the usual --seconds: about half an hour.

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "render/artifact/volume_cap.h"
#include "render/gl/context.h"
#include "render/light_view/auto_depth_source.h"
#include "render/technique/shadow_volume/shadow_volume_builder.h"
#include "tests/bench/bench.h"
#include "tests/bench/shadow_volume_rows.h"
#include "tests/support/stencil_masks.h"
#include "tests/support/volume_masks.h"
#include "tests/support/volume_scenes.h"

namespace penumbra::bench {
namespace {

using testing::MaskComparison;
using testing::Pose;
using testing::VolumeScene;

constexpr int kRotations = 1000;  // at 2 seconds a case
constexpr uint32_t kSides[] = {256, 512};

// Milliseconds of each phase, one a rotation, and what came of it.
struct Phases {
  std::vector<double> light_view, edges, reconstruct, cap;
  double triangles = 0, cap_triangles = 0, edge_fraction = 0;
  MaskComparison masks;
};

AreaLight PointAt(DVec3 place) {
  return {.id = "light", .shape = PointLight{.position = Vec3(place)}};
}

// Edges and reconstruction apart, for the table; what is kept is made by ReconstructVolume.
void Measure(std::vector<VolumeFace> faces, const ShadowVolumeOptions& options, Phases& phases,
             ShadowVolumeMesh& mesh) {
  const double start = NowMs();
  const VolumeGrid grid(faces.at(0).map, faces.at(0).border, options.bias_px);
  const EdgeMap edges = FindEdges(grid, options.edges);
  const double middle = NowMs();
  VolumeTriangles triangles;
  AddTriangles(grid, edges, options.reconstruction, triangles);
  phases.reconstruct.push_back(NowMs() - middle);
  phases.edges.push_back(middle - start);
  phases.edge_fraction += edges.fraction();
  phases.triangles += static_cast<double>(triangles.indices.size() / 3);
  mesh.volumes.push_back(
      std::make_shared<ShadowVolume>(ShadowVolume{.faces = std::move(faces),
                                                  .vertices = std::move(triangles.vertices),
                                                  .indices = std::move(triangles.indices)}));
}

// One rotation.
struct Turn {
  const VolumeScene& scene;
  const testing::EyeRays& rays;
  CasterBvhs& bvhs;
  tbb::task_arena& arena;
  testing::StencilMasks& stencil;
  uint32_t side;

  void Run(int number, Phases& phases) const {
    const Pose pose = Pose::Random(static_cast<uint64_t>(number) + 1);
    const AreaLight light = PointAt(pose.light);
    ShadowVolumeOptions options{.resolution = side};
    AutoDepthSource source(*scene.scene, bvhs, arena);
    const auto views = VolumeViews(light, scene.scene->casters().bounds(),
                                   PitchFor(light, scene.scene->Bounds(), side));
    const double start = NowMs();
    auto faces = OrDie(DrawFaces(views, source, {}));
    phases.light_view.push_back(NowMs() - start);
    ShadowVolumeMesh mesh{.light = light, .bias_px = options.bias_px, .volumes = {}};
    Measure(std::move(faces), options, phases, mesh);
    const testing::EyeImage eye = pose.Image(side);
    const VolumeCapper capper(*mesh.volumes[0], mesh.bias_px, light);
    const double middle = NowMs();
    phases.cap_triangles +=
        static_cast<double>(capper.CapsFor(eye.clip_from_world, eye.near).triangle_count());
    phases.cap.push_back(NowMs() - middle);
    std::vector<uint8_t> drawn =
        stencil.MaskOf(*testing::WithLight(*scene.scene, light), testing::ArtifactOf(mesh), eye);
    phases.masks.Add(testing::CompareMasks({.rays = rays,
                                            .mesh = mesh,
                                            .eye = eye,
                                            .light = DVec4(DVec3(Vec3(pose.light)), 1.0),
                                            .drawn = std::move(drawn)},
                                           arena));
  }
};

double Part(size_t part, size_t of) {
  return of == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(of);
}

void AddRows(const std::string& prefix, const Phases& phases, std::vector<Row>& rows) {
  const auto count = static_cast<double>(phases.edges.size());
  const MaskComparison& masks = phases.masks;
  rows.insert(rows.end(),
              {{prefix + "light_view", Median(phases.light_view), "ms"},
               {prefix + "edges", Median(phases.edges), "ms"},
               {prefix + "reconstruct", Median(phases.reconstruct), "ms"},
               {prefix + "cap", Median(phases.cap), "ms"},
               {prefix + "volume_triangles", phases.triangles / count, "1"},
               {prefix + "edge_fraction", phases.edge_fraction / count, "1"},
               {prefix + "mask_mismatch", Part(masks.not_as_rays, masks.pixels), "1"},
               {prefix + "mask_near_boundary", 1 - Part(masks.astray, masks.not_as_rays), "1"},
               {prefix + "largest_astray", static_cast<double>(masks.largest_astray), "px"},
               {prefix + "mask_vs_map", Part(masks.not_as_map, masks.pixels), "1"},
               {prefix + "map_mismatch", Part(masks.map_not_as_rays, masks.pixels), "1"}});
}

int RotationsFor(const BenchOptions& options) {
  return std::clamp(static_cast<int>(kRotations * options.min_seconds / 2), 2, kRotations);
}

void AddTables(const VolumeScene& scene, const BenchOptions& options,
               testing::StencilMasks& stencil, std::vector<Row>& rows) {
  tbb::task_arena arena(options.threads);
  CasterBvhs bvhs;
  const testing::EyeRays rays(*scene.scene);
  double triangles[2] = {0, 0};
  const std::string name = std::string("shadow_volume.") + scene.name;
  rows.push_back({name + ".scene_triangles", static_cast<double>(scene.triangles), "1"});
  for (size_t size = 0; size < 2; ++size) {
    Phases phases;
    const Turn turn{scene, rays, bvhs, arena, stencil, kSides[size]};
    for (int i = 0; i < RotationsFor(options); ++i) turn.Run(i, phases);
    triangles[size] = phases.triangles;
    AddRows(name + std::to_string(kSides[size]) + ".", phases, rows);
  }
  rows.push_back({name + "512.complexity_ratio", triangles[1] / triangles[0], "1"});
}

}  // namespace

std::vector<Row> ShadowVolumeSuite(const BenchOptions& options) {
  std::vector<Row> rows;
  const auto context = OrDie(gl::Context::Create());
  testing::StencilMasks stencil(*context);
  AddRebuildRows(options, rows);
  AddPerObjectRows(options, rows);
  AddCameraRows(options, stencil, rows);
  AddVectorizedRows(options, rows);
  for (const VolumeScene& scene : testing::VolumeScenes()) {
    AddTables(scene, options, stencil, rows);
  }
  return rows;
}

}  // namespace penumbra::bench
