#include "tests/bench/shadow_volume_rows.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <string>
#include <utility>

#include "render/light_view/auto_depth_source.h"
#include "render/light_view/raster_depth_source.h"
#include "render/light_view/ray_depth_source.h"
#include "render/technique/shadow_volume/object_volumes.h"
#include "render/technique/shadow_volume/shadow_volume_builder.h"
#include "tests/support/random_scene.h"
#include "tests/support/rippled_torus.h"
#include "tests/support/shapes.h"
#include "tests/support/volume_masks.h"
#include "tests/support/volume_scenes.h"

namespace penumbra::bench {
namespace {

using testing::Dice;
using testing::EyeImage;
using testing::MaskComparison;
using testing::MeshOf;
using testing::Placed;
using testing::Pose;

AreaLight PointAt(Vec3 place) { return {.id = "light", .shape = PointLight{.position = place}}; }

std::shared_ptr<const Scene> SceneOf(std::vector<Instance> instances) {
  instances.push_back({.id = "ground",
                       .mesh = MeshOf(testing::UnitSquareGeometry()),
                       .world_from_mesh = Placed(Vec3(0), 4)});
  SceneDelta delta;
  delta.upsert_instances = std::move(instances);
  return OrDie(Scene::Empty("scene")->Apply(delta));
}

double Part(size_t part, size_t of) {
  return of == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(of);
}

// As many as 2 seconds a case make of it.
int CountFor(const BenchOptions& options, int usual) {
  return std::clamp(static_cast<int>(usual * options.min_seconds / 2), 2, usual);
}

struct Vectorized {
  double triangles = 0, walls = 0;
  MaskComparison by_triangles, by_walls;
};

void Compare(const testing::VolumeScene& scene, int rotations, tbb::task_arena& arena,
             Vectorized& sum) {
  CasterBvhs bvhs;
  const testing::EyeRays rays(*scene.scene);
  for (int i = 0; i < rotations; ++i) {
    const Pose pose = Pose::Random(static_cast<uint64_t>(i) + 1);
    const AreaLight light = PointAt(Vec3(pose.light));
    const EyeImage eye = pose.Image(512);
    AutoDepthSource source(*scene.scene, bvhs, arena);
    for (const bool vectorizes : {false, true}) {
      const ShadowVolumeMesh mesh =
          OrDie(BuildShadowVolumes(*scene.scene, light, {.vectorizes = vectorizes}, source, {}));
      (vectorizes ? sum.by_walls : sum.by_triangles)
          .Add(testing::CompareMasks({.rays = rays,
                                      .mesh = mesh,
                                      .eye = eye,
                                      .light = DVec4(DVec3(Vec3(pose.light)), 1.0)},
                                     arena));
      // A wall is a polygon of two triangles.
      const auto count = static_cast<double>(mesh.triangle_count());
      (vectorizes ? sum.walls : sum.triangles) += vectorizes ? 0.5 * count : count;
    }
  }
}

// A hundred balls and boxes side by side.
std::vector<Instance> Hundred() {
  const auto ball = MeshOf(testing::BallGeometry(48, 24)), box = MeshOf(testing::UnitBoxGeometry());
  std::vector<Instance> things;
  for (int i = 0; i < 100; ++i) {
    const Vec3 at(0.7f * static_cast<float>(i % 10) - 3.1f, 0.3f,
                  0.7f * static_cast<float>(i / 10) - 3.1f);
    things.push_back({.id = "thing" + std::to_string(i),
                      .mesh = i % 2 ? ball : box,
                      .world_from_mesh = Placed(at, 0.25f)});
  }
  return things;
}

// Whether a place is within a closed mesh, from where there is no outside to see.
bool IsInside(const Scene& scene, DVec3 place) {
  for (const auto& [id, instance] : scene.instances()) {
    if (instance->mesh->closure() == MeshClosure::kOpen || id == "walls") continue;
    const auto indices = instance->mesh->indices();
    const DVec3 way(0.2137, 0.8731, 0.3719);
    bool is_inside = false;
    for (size_t i = 0; i < indices.size(); i += 3) {
      DVec3 at[3];
      for (size_t k = 0; k < 3; ++k) {
        const Vec3 p = instance->mesh->positions()[indices[i + k]];
        at[k] = DVec3(TransformPoint(instance->world_from_mesh, p)) - place;
      }
      const double a = glm::dot(way, glm::cross(at[0], at[1]));
      const double b = glm::dot(way, glm::cross(at[1], at[2]));
      const double c = glm::dot(way, glm::cross(at[2], at[0]));
      if ((a < 0) != (b < 0) || (b < 0) != (c < 0)) continue;
      const DVec3 normal = glm::cross(at[1] - at[0], at[2] - at[0]);
      is_inside ^= glm::dot(normal, at[0]) / glm::dot(normal, way) > 0;
    }
    if (is_inside) return true;
  }
  return false;
}

// Of one mesh, from random eyes outside of what is solid.
MaskComparison FromRandomEyes(const Scene& scene, Vec3 light, int count,
                              const BenchOptions& options, testing::StencilMasks& stencil) {
  tbb::task_arena arena(options.threads);
  CasterBvhs bvhs;
  AutoDepthSource source(scene, bvhs, arena);
  const testing::EyeRays rays(scene);
  const ShadowVolumeMesh mesh = OrDie(BuildShadowVolumes(scene, PointAt(light), {}, source, {}));
  const auto lit = testing::WithLight(scene, PointAt(light));
  const auto artifact = testing::ArtifactOf(mesh);
  Dice dice(61);
  MaskComparison sum;
  for (int i = 0; i < count; ++i) {
    DVec3 eye;
    do {
      eye = DVec3(dice.InCube(1.4f)) * DVec3(1, 0.6, 1);
    } while (IsInside(scene, eye));
    const DVec3 target = i % 3 == 0 ? DVec3(light) : DVec3(dice.InCube(1.2f));
    const double near = dice.Between(0.01f, 0.1f);
    const EyeImage image{
        .clip_from_world = glm::perspective(1.0, 1.0, near, 100.0) *
                           glm::lookAt(eye, target + DVec3(1e-3), DVec3(0.1, 1, 0.3)),
        .width = 192,
        .height = 192,
        .near = near};
    sum.Add(testing::CompareMasks({.rays = rays,
                                   .mesh = mesh,
                                   .eye = image,
                                   .light = DVec4(DVec3(light), 1.0),
                                   .drawn = stencil.MaskOf(*lit, artifact, image)},
                                  arena));
  }
  return sum;
}

void AddCameraRows(const std::string& prefix, const MaskComparison& masks, std::vector<Row>& rows) {
  rows.insert(
      rows.end(),
      {{prefix + "mask_mismatch", Part(masks.not_as_rays, masks.pixels), "1"},
       {prefix + "mask_vs_map", Part(masks.not_as_map, masks.pixels), "1"},
       {prefix + "largest_astray", static_cast<double>(masks.largest_astray), "px"},
       {prefix + "largest_unlike_map", static_cast<double>(masks.largest_unlike_map), "px"}});
}

// The same things with walls around.
std::shared_ptr<const Scene> Room() {
  std::vector<Instance> things;
  const auto box = MeshOf(testing::UnitBoxGeometry());
  Dice dice(62);
  for (int i = 0; i < 24; ++i) {
    things.push_back({.id = "thing" + std::to_string(i),
                      .mesh = i % 2 ? MeshOf(testing::BallGeometry(32, 16)) : box,
                      .world_from_mesh = dice.AnyAffine(0.15f, 1.3f * dice.Direction())});
  }
  things.push_back({.id = "walls", .mesh = box, .world_from_mesh = Placed(Vec3(0), 2)});
  return SceneOf(std::move(things));
}

}  // namespace

void AddRebuildRows(const BenchOptions& options, std::vector<Row>& rows) {
  const auto scene = SceneOf({{.id = "torus",
                               .mesh = MeshOf(testing::RippledTorus(500, 200)),
                               .world_from_mesh = Placed(Vec3(0, 1, 0))}});
  tbb::task_arena arena(options.threads);
  CasterBvhs bvhs;
  RayDepthSource rays(bvhs.Of(*scene), arena);
  RasterDepthSource raster(*scene, arena);
  const AreaLight light = PointAt(Vec3(2, 6, 1));
  const auto views =
      VolumeViews(light, scene->casters().bounds(), PitchFor(light, scene->Bounds(), 512));
  const std::vector<VolumeFace> faces = OrDie(DrawFaces(views, rays, {}));
  const auto rebuild = [&] {
    const VolumeGrid grid(faces[0].map, faces[0].border, 1);
    VolumeTriangles triangles;
    AddTriangles(grid, FindEdges(grid, {}), Reconstruction::kTemplate, triangles);
  };
  const Duel by_rays =
      Interleave(0.5 * options.min_seconds, rebuild, [&] { OrDie(DrawFaces(views, rays, {})); });
  const Duel by_raster =
      Interleave(0.5 * options.min_seconds, rebuild, [&] { OrDie(DrawFaces(views, raster, {})); });
  const double faster = std::min(by_rays.PeersMs(), by_raster.PeersMs());
  rows.insert(rows.end(),
              {{"shadow_volume.rebuild.edges_and_triangles", by_raster.OursMs(), "ms"},
               {"shadow_volume.rebuild.map_by_rays", by_rays.PeersMs(), "ms"},
               {"shadow_volume.rebuild.map_by_raster", by_raster.PeersMs(), "ms"},
               {"shadow_volume.rebuild.cost_vs_depth_map", by_raster.OursMs() / faster, "1"}});
}

void AddVectorizedRows(const BenchOptions& options, std::vector<Row>& rows) {
  tbb::task_arena arena(options.threads);
  Vectorized all;
  for (const testing::VolumeScene& scene : testing::VolumeScenes()) {
    Vectorized sum;
    Compare(scene, CountFor(options, 24), arena, sum);
    const std::string prefix = std::string("shadow_volume.vectorised.") + scene.name + ".";
    rows.insert(rows.end(), {{prefix + "polygon_ratio", sum.triangles / sum.walls, "1"},
                             {prefix + "mask_mismatch",
                              Part(sum.by_walls.not_as_rays, sum.by_walls.pixels), "1"},
                             {prefix + "mismatch_of_triangles",
                              Part(sum.by_triangles.not_as_rays, sum.by_triangles.pixels), "1"}});
    all.triangles += sum.triangles, all.walls += sum.walls;
    all.by_walls.Add(sum.by_walls), all.by_triangles.Add(sum.by_triangles);
  }
  rows.insert(rows.end(),
              {{"shadow_volume.vectorised.polygon_ratio", all.triangles / all.walls, "1"},
               {"shadow_volume.vectorised.mismatch_vs_triangles",
                Part(all.by_walls.not_as_rays, all.by_triangles.not_as_rays), "1"}});
}

void AddPerObjectRows(const BenchOptions& options, std::vector<Row>& rows) {
  tbb::task_arena arena(options.threads);
  CasterBvhs bvhs;
  const ObjectVolumes::SourceOf source_of = [&](const Scene& scene) {
    return std::make_unique<AutoDepthSource>(scene, bvhs, arena);
  };
  auto scene = SceneOf(Hundred());
  const AreaLight light = PointAt(Vec3(1, 9, 2));
  ObjectVolumes kept({}, ObjectPrecision::kNever);
  OrDie(kept.Update(*scene, light, source_of, {}));
  int moves = 0;
  const auto move = [&] {
    Instance thing = *scene->FindInstance("thing37");
    thing.world_from_mesh[3].y = 0.3f + 0.01f * static_cast<float>(++moves % 20);
    SceneDelta delta;
    delta.upsert_instances = {thing};
    scene = OrDie(scene->Apply(delta));
    OrDie(kept.Update(*scene, light, source_of, {}));
  };
  const auto all_anew = [&] {
    ObjectVolumes fresh({}, ObjectPrecision::kNever);
    OrDie(fresh.Update(*scene, light, source_of, {}));
  };
  const auto as_one = [&] {
    const auto source = OrDie(source_of(*scene));
    OrDie(BuildShadowVolumes(*scene, light, {}, *source, {}));
  };
  const Duel duel = Interleave(options.min_seconds, move, all_anew);
  const Duel one = Interleave(0.5 * options.min_seconds, move, as_one);
  rows.insert(rows.end(), {{"shadow_volume.per_object.move", duel.OursMs(), "ms"},
                           {"shadow_volume.per_object.all", duel.PeersMs(), "ms"},
                           {"shadow_volume.per_object.speedup_vs_full", duel.Speedup(), "x"},
                           {"shadow_volume.per_object.as_one_volume", one.PeersMs(), "ms"}});
}

void AddCameraRows(const BenchOptions& options, testing::StencilMasks& stencil,
                   std::vector<Row>& rows) {
  const auto scenes = testing::VolumeScenes();
  const int count = CountFor(options, 1000);
  AddCameraRows("shadow_volume.cameras.",
                FromRandomEyes(*scenes[1].scene, Vec3(2, 3, 1), count, options, stencil), rows);
  AddCameraRows("shadow_volume.room.",
                FromRandomEyes(*Room(), Vec3(0.1f, 0.2f, 0), count, options, stencil), rows);
}

}  // namespace penumbra::bench
