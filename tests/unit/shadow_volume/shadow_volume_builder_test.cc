// Volumes of whole scenes: from outside, from the middle of a room, and of what is no scene at all.
#include "render/technique/shadow_volume/shadow_volume_builder.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <utility>

#include "render/artifact/volume_cap.h"
#include "render/light_view/auto_depth_source.h"
#include "render/light_view/raster_depth_source.h"
#include "render/light_view/ray_depth_source.h"
#include "tests/support/pile_of_things.h"
#include "tests/support/random_scene.h"
#include "tests/support/volume_masks.h"

namespace penumbra {
namespace {

using testing::CompareMasks;
using testing::Dice;
using testing::EyeImage;
using testing::MeshOf;
using testing::Placed;

AreaLight PointLightAt(Vec3 place) {
  return {.id = "light", .shape = PointLight{.position = place}};
}

std::shared_ptr<const Scene> SceneOf(std::vector<Instance> instances) {
  SceneDelta delta;
  delta.upsert_instances = std::move(instances);
  return Scene::Empty("scene")->Apply(delta).value();
}

// Walls all around, and what throws shadows on them.
std::shared_ptr<const Scene> Room() {
  const auto box = MeshOf(testing::UnitBoxGeometry());
  std::vector<Instance> instances = {
      {.id = "walls", .mesh = box, .world_from_mesh = Placed(Vec3(0), Vec3(3, 2, 2.5f))},
      {.id = "ball",
       .mesh = MeshOf(testing::BallGeometry(40, 20)),
       .world_from_mesh = Placed(Vec3(-1, 0.9f, 1), 0.35f)}};
  for (int i = 0; i < 6; ++i) {
    const auto k = static_cast<float>(i);
    instances.push_back(
        {.id = "post" + std::to_string(i),
         .mesh = box,
         .world_from_mesh = Placed(Vec3(1.7f * std::cos(k), 0.4f * k - 1, 1.4f * std::sin(k)),
                                   Vec3(0.1f, 0.5f, 0.15f))});
  }
  return SceneOf(std::move(instances));
}

EyeImage EyeAt(DVec3 eye, DVec3 target) {
  const DMat4 view = glm::lookAt(eye, target, DVec3(0.1, 1, 0.2));
  return {.clip_from_world = glm::perspective(1.1, 1.0, 0.05, 100.0) * view,
          .width = 160,
          .height = 160,
          .near = 0.05};
}

class ShadowVolumeBuilderTest : public ::testing::Test {
 protected:
  ShadowVolumeMesh Build(const Scene& scene, const AreaLight& light,
                         const ShadowVolumeOptions& options = {.resolution = 256}) {
    AutoDepthSource source(scene, bvhs_, arena_);
    return BuildShadowVolumes(scene, light, options, source, {}).value();
  }

  CasterBvhs bvhs_;
  tbb::task_arena arena_{2};
};

// Maps of six views with random depths: where faces meet, each edge has a triangle on either face.
TEST(VolumeViewsTest, SixViewsCloseUp) {
  const AreaLight light = PointLightAt(Vec3(0.3f, -0.2f, 0.1f));
  const Aabb around{.min = Vec3(-2), .max = Vec3(2)};
  const auto views = VolumeViews(light, std::span(&around, 1), 2.0 / 7);
  ASSERT_EQ(views.size(), 6u);
  Dice dice(51);
  std::vector<DepthMap> maps;
  for (const VolumeView& view : views) {
    EXPECT_EQ(view.border, VolumeBorder::kOthers);
    DepthMap map{.view = view.view, .depths = {}};
    for (uint32_t i = 0; i < view.view.width * view.view.height; ++i) {
      map.depths.push_back(dice.Between(1, 4));
    }
    maps.push_back(std::move(map));
  }
  JoinBorders(maps);
  std::vector<VolumeFace> faces;
  for (DepthMap& map : maps) faces.push_back({std::move(map), VolumeBorder::kOthers});
  const ShadowVolume volume =
      ReconstructVolume(std::move(faces), {.reconstruction = Reconstruction::kAllCells}, {})
          .value()
          .volume;
  EXPECT_EQ(volume.triangle_count(), 6u * 7 * 7 * 2);
  using Place = std::array<float, 4>;
  std::map<std::pair<Place, Place>, int> uses;
  for (size_t i = 0; i < volume.indices.size(); ++i) {
    const auto place = [&](size_t k) {
      const Vec4 v = volume.vertices[volume.indices[k]];
      return Place{v.x, v.y, v.z, v.w};
    };
    ++uses[std::minmax(place(i), place(i % 3 == 2 ? i - 2 : i + 1))];
  }
  EXPECT_EQ(uses.size(), 6u * 7 * 7 * 3);
  for (const auto& [edge, count] : uses) EXPECT_EQ(count, 2);
}

// Half of the six frames are left-handed, which sources must not care for.
TEST_F(ShadowVolumeBuilderTest, SourcesAgreeOnSixViews) {
  const auto scene = Room();
  const auto views = VolumeViews(PointLightAt(Vec3(0.1f)), scene->casters().bounds(), 2.0 / 64);
  RayDepthSource rays(bvhs_.Of(*scene), arena_);
  RasterDepthSource raster(*scene, arena_);
  const auto by_rays = DrawFaces(views, rays, {}).value();
  const auto by_raster = DrawFaces(views, raster, {}).value();
  ASSERT_EQ(by_rays.size(), 6u);
  size_t different = 0, all = 0;
  for (size_t face = 0; face < 6; ++face) {
    for (size_t i = 0; i < by_rays[face].map.depths.size(); ++i) {
      const double a = by_rays[face].map.depths[i], b = by_raster[face].map.depths[i];
      EXPECT_TRUE(std::isfinite(a));
      different += !(std::abs(a - b) <= 1e-4 * a);
      ++all;
    }
  }
  EXPECT_LT(different, all / 500);
}

TEST_F(ShadowVolumeBuilderTest, ALightInARoomCastsItsShadowsAllAround) {
  const auto scene = Room();
  const Vec3 place(0.1f, 0.2f, -0.1f);
  const testing::EyeRays rays(*scene);
  for (const bool vectorizes : {false, true}) {
    const auto mesh =
        Build(*scene, PointLightAt(place), {.resolution = 256, .vectorizes = vectorizes});
    ASSERT_EQ(mesh.volumes.size(), 1u);
    EXPECT_EQ(mesh.volumes[0]->faces.size(), 6u);
    testing::MaskComparison sum;
    Dice dice(52);
    for (int i = 0; i < 12; ++i) {
      const DVec3 eye(dice.Between(-2.8f, 2.8f), dice.Between(-1.8f, 1.8f),
                      dice.Between(-2.3f, 2.3f));
      const DVec3 target = i % 4 == 0 ? DVec3(place) : DVec3(dice.InCube(1.5f));
      const EyeImage image = EyeAt(eye, target);
      const auto one = CompareMasks(
          {.rays = rays, .mesh = mesh, .eye = image, .light = DVec4(DVec3(place), 1)}, arena_);
      sum.Add(one);
    }
    EXPECT_LT(sum.not_as_rays, sum.pixels / 50) << vectorizes;
    if (vectorizes) continue;
    EXPECT_LE(sum.largest_astray, 16u);
    EXPECT_LT(sum.not_as_map, sum.pixels / 300);
  }
}

TEST_F(ShadowVolumeBuilderTest, OfADistantLight) {
  auto pile = testing::PileOfThings();
  pile.push_back({.id = "floor",
                  .mesh = MeshOf(testing::UnitSquareGeometry()),
                  .world_from_mesh = Placed(Vec3(0), 5)});
  const auto scene = SceneOf(std::move(pile));
  const AreaLight sun{.id = "light", .shape = DistantLight{.to_light = Vec3(0.3f, 1, 0.4f)}};
  const auto mesh = Build(*scene, sun);
  const testing::EyeRays rays(*scene);
  testing::MaskComparison sum;
  Dice dice(53);
  for (int i = 0; i < 6; ++i) {
    const EyeImage eye =
        EyeAt(DVec3(dice.Between(-5, 5), dice.Between(0.2f, 5), dice.Between(-5, 5)),
              DVec3(dice.InCube(1)));
    sum.Add(CompareMasks({.rays = rays, .mesh = mesh, .eye = eye, .light = DVec4(0.3, 1, 0.4, 0)},
                         arena_));
  }
  EXPECT_LT(sum.not_as_rays, sum.pixels / 50);
  EXPECT_LT(sum.not_as_map, sum.pixels / 300);
  EXPECT_LE(sum.largest_astray, 16u);
}

TEST_F(ShadowVolumeBuilderTest, WhatTheLightDoesNotSeeHasNoVolume) {
  const auto nothing = Scene::Empty("nothing");
  EXPECT_TRUE(Build(*nothing, PointLightAt(Vec3(0))).volumes.empty());
  const auto scene = Room();
  const AreaLight away{.id = "light",
                       .shape = SpotLight{.position = Vec3(0, 9, 0),
                                          .direction = Vec3(0, 1, 0),
                                          .inner_angle = 0.3f,
                                          .outer_angle = 0.5f}};
  const auto mesh = Build(*scene, away);
  EXPECT_TRUE(mesh.volumes.empty());
  EXPECT_EQ(mesh.triangle_count(), 0u);
  EXPECT_EQ(Visibility(mesh, Vec3(0, 3, 0), Vec3(0, 1, 0)), 1.0f);
}

// No map is too small or too strange to have a volume, and no eye to have caps.
TEST(ReconstructVolumeTest, BadMapsHaveFiniteVolumes) {
  const float kBad[] = {NAN, -1, 0, INFINITY, 1e-44f, 1e38f, 2, -INFINITY, 3};
  Dice dice(54);
  for (const bool from_infinity : {false, true}) {
    for (const auto& [width, height] : {std::pair{0, 0}, {1, 1}, {1, 9}, {70, 3}, {33, 40}}) {
      DepthMap map{.view = {.from_infinity = from_infinity,
                            .window = {.min = DVec2(-1), .max = DVec2(1)},
                            .width = static_cast<uint32_t>(width),
                            .height = static_cast<uint32_t>(height)},
                   .depths = {}};
      for (int i = 0; i < width * height; ++i) map.depths.push_back(kBad[dice.Below(9)]);
      for (const bool vectorizes : {false, true}) {
        const ShadowVolume volume =
            ReconstructVolume({{.map = map}}, {.vectorizes = vectorizes}, {}).value().volume;
        for (const Vec4& v : volume.vertices) {
          EXPECT_TRUE(std::isfinite(v.x + v.y + v.z + v.w) && v.w >= 0);
        }
        // On the light, on a sample, and across everything.
        for (const DVec3 eye : {DVec3(0), DVec3(0, 0, 2), DVec3(3, 0, 1)}) {
          const EyeImage image = EyeAt(eye, DVec3(0.1, 0, 2.5));
          const VolumeCaps caps = VolumeCapper(volume, 0.25f, PointLightAt(Vec3(0)))
                                      .CapsFor(image.clip_from_world, image.near);
          for (const Vec4& v : caps.corners) EXPECT_TRUE(std::isfinite(v.x + v.y + v.w));
        }
      }
    }
  }
}

// Of six maps over a plane some see nothing, and count for nothing.
TEST_F(ShadowVolumeBuilderTest, TheFractionIsOfWhatIsSeen) {
  Instance plane{.id = "plane", .mesh = MeshOf(testing::UnitSquareGeometry())};
  plane.world_from_mesh = Affine(Vec3(3, 0.7f, 0.1f), Vec3(0, 1, 0), Vec3(0.2f, 0.5f, 3), Vec3(0));
  ShadowVolumeOptions options{.resolution = 32};
  options.edges.thresholds = EdgeThresholds{.low = 0, .high = 0};
  const auto mesh = Build(*SceneOf({plane}), PointLightAt(Vec3(0, 0.3f, 0)), options);
  ASSERT_EQ(mesh.volumes[0]->faces.size(), 6u);
  EXPECT_GT(mesh.edge_fraction, 0.95f);
}

TEST_F(ShadowVolumeBuilderTest, ThresholdsThatTakeAllAreStillRight) {
  const auto scene = Room();
  const Vec3 place(5, 6, 4);
  ShadowVolumeOptions options{.resolution = 64};
  options.edges.thresholds = EdgeThresholds{.low = 0, .high = 0};
  const auto mesh = Build(*scene, PointLightAt(place), options);
  EXPECT_GT(mesh.edge_fraction, 0.3f);
  const testing::EyeRays rays(*scene);
  const auto masks = CompareMasks({.rays = rays,
                                   .mesh = mesh,
                                   .eye = EyeAt(DVec3(4, 1, 6), DVec3(0)),
                                   .light = DVec4(DVec3(place), 1)},
                                  arena_);
  EXPECT_LT(masks.not_as_map, masks.pixels / 1000);
}

}  // namespace
}  // namespace penumbra
