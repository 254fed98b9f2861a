// Shadow volumes by the stencil, against the same mesh counted on the CPU and against rays.
#include "client/display/volume_shadows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "render/artifact/light_extent.h"
#include "render/light_view/auto_depth_source.h"
#include "render/technique/shadow_volume/object_volumes.h"
#include "render/technique/shadow_volume/shadow_volume_builder.h"
#include "tests/gl/display/small_scenes.h"
#include "tests/gl/display/software_context.h"
#include "tests/support/pile_of_things.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"
#include "tests/support/stencil_masks.h"
#include "tests/support/volume_masks.h"

namespace penumbra {
namespace {

using testing::Dice;
using testing::EyeImage;
using testing::MaskComparison;
using testing::MeshOf;
using testing::Placed;

AreaLight PointAt(Vec3 place) {
  return {.id = "light", .shape = PointLight{.position = place, .intensity = Vec3(100)}};
}

std::shared_ptr<const Scene> PileOnFloor() {
  SceneDelta delta;
  delta.upsert_instances = testing::PileOfThings();
  delta.upsert_instances.push_back({.id = "floor",
                                    .mesh = MeshOf(testing::UnitSquareGeometry()),
                                    .world_from_mesh = Placed(Vec3(0), 5)});
  return SceneOf(delta);
}

// The same with walls around.
std::shared_ptr<const Scene> PileInRoom() {
  SceneDelta delta;
  delta.upsert_instances.push_back({.id = "walls",
                                    .mesh = MeshOf(testing::UnitBoxGeometry()),
                                    .world_from_mesh = Placed(Vec3(0, 1, 0), 4)});
  return PileOnFloor()->Apply(delta).value();
}

EyeImage EyeAt(DVec3 from, DVec3 to, double near) {
  return {.clip_from_world =
              glm::perspective(1.0, 1.0, near, 100.0) * glm::lookAt(from, to, DVec3(0.1, 1, 0.2)),
          .width = 160,
          .height = 160,
          .near = near};
}

class VolumeShadowsTest : public SoftwareContextTest {
 protected:
  ShadowVolumeMesh Build(const Scene& scene, const AreaLight& light,
                         const ShadowVolumeOptions& options = {.resolution = 256}) {
    AutoDepthSource source(scene, bvhs_, arena_);
    return BuildShadowVolumes(scene, light, options, source, {}).value();
  }
  ShadowVolumeMesh BuildOfEach(const Scene& scene, const AreaLight& light,
                               ObjectPrecision precision) {
    const auto source_of = [this](const Scene& alone) {
      return std::make_unique<AutoDepthSource>(alone, bvhs_, arena_);
    };
    return ObjectVolumes({.resolution = 256}, precision)
        .Update(scene, light, source_of, {})
        .value();
  }

  // From random eyes, every fourth towards the light, with near planes that cut much or little:
  // calls take(eye, what it sees, what the stencil has).
  template <typename Take>
  void ForEachEye(const Scene& scene, const ShadowVolumeMesh& mesh, double reach, int eyes,
                  const Take& take) {
    testing::StencilMasks masks(*context_);
    const auto lit = testing::WithLight(scene, mesh.light);
    const auto artifact = testing::ArtifactOf(mesh);
    const testing::EyeRays rays(scene);
    Dice dice(71);
    for (int i = 0; i < eyes; ++i) {
      const DVec3 from = DVec3(0, 1, 0) + reach * DVec3(dice.InCube(1)) * DVec3(1, 0.6, 1);
      const DVec3 to = i % 4 == 0 ? DVec3(LightOf(mesh)) + (1 - LightOf(mesh).w) * from
                                  : DVec3(dice.InCube(1.2f));
      const EyeImage eye = EyeAt(from, to + DVec3(1e-3), i % 2 == 0 ? 0.02 : 0.4);
      take(eye, rays, masks.MaskOf(*lit, artifact, eye));
    }
  }
  // A place, or a direction.
  static DVec4 LightOf(const ShadowVolumeMesh& mesh) { return PlaceOfMiddle(mesh.light); }

  // Against rays and, of all that they see, the same mesh's crossings counted on the CPU.
  MaskComparison Compare(const Scene& scene, const ShadowVolumeMesh& mesh, double reach,
                         size_t& not_as_cpu) {
    MaskComparison sum;
    ForEachEye(scene, mesh, reach, 12,
               [&](const EyeImage& eye, const testing::EyeRays& rays, std::vector<uint8_t> drawn) {
                 const testing::EyeView view = rays.See(eye, arena_);
                 const std::vector<uint8_t> counted = testing::MaskOf(mesh, eye, view);
                 for (size_t i = 0; i < drawn.size(); ++i) {
                   not_as_cpu += view.inverse_depths[i] != 0 && drawn[i] != counted[i];
                 }
                 sum.Add(testing::CompareMasks({.rays = rays,
                                                .mesh = mesh,
                                                .eye = eye,
                                                .light = LightOf(mesh),
                                                .drawn = std::move(drawn)},
                                               arena_));
               });
    return sum;
  }

  CasterBvhs bvhs_;
  tbb::task_arena arena_{2};
};

TEST_F(VolumeShadowsTest, TheStencilHoldsTheParity) {
  const auto scene = PileOnFloor();
  for (const bool vectorizes : {false, true}) {
    const auto mesh =
        Build(*scene, PointAt(Vec3(1, 5, 2)), {.resolution = 256, .vectorizes = vectorizes});
    size_t not_as_cpu = 0;
    const MaskComparison masks = Compare(*scene, mesh, 4, not_as_cpu);
    EXPECT_LT(not_as_cpu, masks.pixels / 500) << vectorizes;
    EXPECT_LT(masks.not_as_rays, masks.pixels / 50) << vectorizes;
    EXPECT_LE(masks.largest_astray, vectorizes ? 64u : 16u);
  }
}

TEST_F(VolumeShadowsTest, SixViewsHaveNoCracksBetween) {
  const auto scene = PileInRoom();
  const auto mesh = Build(*scene, PointAt(Vec3(0.2f, 1.7f, -0.1f)));
  ASSERT_EQ(mesh.volumes.at(0)->faces.size(), 6u);
  size_t not_as_cpu = 0;
  const MaskComparison masks = Compare(*scene, mesh, 1.5, not_as_cpu);
  EXPECT_LT(not_as_cpu, masks.pixels / 500);
  EXPECT_LT(masks.not_as_rays, masks.pixels / 50);
  EXPECT_LE(masks.largest_astray, 16u);
}

// Its volumes reach a point infinitely far, and the ground has nothing behind it.
TEST_F(VolumeShadowsTest, TheSunsVolumesReachInfinitelyFar) {
  const auto scene = PileOnFloor();
  const AreaLight sun{
      .id = "light", .shape = DistantLight{.to_light = Vec3(0.4f, 1, 0.3f), .irradiance = Vec3(1)}};
  const auto mesh = Build(*scene, sun);
  size_t not_as_cpu = 0;
  const MaskComparison masks = Compare(*scene, mesh, 4, not_as_cpu);
  EXPECT_LT(not_as_cpu, masks.pixels / 500);
  EXPECT_LT(masks.not_as_rays, masks.pixels / 50);
  EXPECT_LE(masks.largest_astray, 16u);
}

TEST_F(VolumeShadowsTest, VolumesOfManyAreUnitedByCounting) {
  const auto scene = PileOnFloor();
  for (const auto precision : {ObjectPrecision::kNever, ObjectPrecision::kWhereItIsLess}) {
    const auto mesh = BuildOfEach(*scene, PointAt(Vec3(1, 5, 2)), precision);
    EXPECT_GT(mesh.volumes.size(), 10u);
    size_t pixels = 0, not_as_cpu = 0, not_as_rays = 0;
    ForEachEye(
        *scene, mesh, 4, 8,
        [&](const EyeImage& eye, const testing::EyeRays& rays, const std::vector<uint8_t>& drawn) {
          const testing::EyeView view = rays.See(eye, arena_);
          const auto counted = testing::MaskOf(mesh, eye, view);
          const auto traced = rays.Shadow(view, LightOf(mesh), 1e-4f, arena_);
          for (size_t i = 0; i < drawn.size(); ++i) {
            if (view.inverse_depths[i] == 0) continue;
            ++pixels;
            not_as_cpu += drawn[i] != counted[i];
            const DVec3 to_light = DVec3(LightOf(mesh)) - LightOf(mesh).w * DVec3(view.points[i]);
            const bool faces_it = glm::dot(to_light, DVec3(view.normals[i])) > 0;
            not_as_rays += faces_it && drawn[i] != traced[i];
          }
        });
    EXPECT_GT(pixels, 50'000u);
    EXPECT_LT(not_as_cpu, pixels / 300);
    EXPECT_LT(not_as_rays, pixels / 50);
  }
}

TEST(VolumeTurnTest, PassesOfEachDirectionAreEvenlyApart) {
  ShadowVolumeMesh mesh{.light = {.shape = DistantLight{.to_light = Vec3(0, 1, 0)}}};
  LightView view{.from_infinity = true, .width = 64, .height = 64};
  view.frame.axes = {DVec3(1, 0, 0), DVec3(0, 0, 1), DVec3(0, -1, 0)};
  view.window = {.min = DVec2(0), .max = DVec2(64)};
  mesh.volumes.push_back(
      std::make_shared<ShadowVolume>(ShadowVolume{.faces = {{.map = {.view = view}}}}));
  for (const int passes : {2, 7, 16, 64}) {
    std::set<int> along_x, along_z;
    for (int pass = 0; pass < passes; ++pass) {
      const DVec4 moved = VolumeTurn(mesh, pass, passes) * DVec4(0, 0, 0, 1);
      EXPECT_LT(std::abs(moved.x), 0.5);
      EXPECT_LT(std::abs(moved.z), 0.5);
      EXPECT_LT(moved.y, 0.0);
      along_x.insert(static_cast<int>(std::floor((moved.x + 0.5) * passes)));
      along_z.insert(static_cast<int>(std::floor((moved.z + 0.5) * passes)));
    }
    EXPECT_EQ(along_x.size(), static_cast<size_t>(passes));
    EXPECT_EQ(along_z.size(), static_cast<size_t>(passes));
  }
  EXPECT_EQ(VolumeTurn(mesh, 0, 1), DMat4(1.0));
}

// From a place: what is a metre ahead moves by up to half a sample along s and t.
TEST(VolumeTurnTest, TurnsAreOfHalfASample) {
  ShadowVolumeMesh mesh{.light = PointAt(Vec3(1, 2, 3))};
  LightView view{.width = 64, .height = 64};
  view.frame = {.origin = DVec3(1, 2, 3),
                .axes = {DVec3(1, 0, 0), DVec3(0, 0, 1), DVec3(0, -1, 0)}};
  view.window = {.min = DVec2(-0.5), .max = DVec2(0.5)};
  mesh.volumes.push_back(
      std::make_shared<ShadowVolume>(ShadowVolume{.faces = {{.map = {.view = view}}}}));
  const int passes = 16;
  double least = 1, most = -1;
  for (int pass = 0; pass < passes; ++pass) {
    const DVec4 moved = VolumeTurn(mesh, pass, passes) * DVec4(1, 1, 3, 1);
    EXPECT_LT(moved.y, 1.0);
    EXPECT_LT(std::abs(moved.x - 1) * 64, 0.52);
    EXPECT_LT(std::abs(moved.z - 3) * 64, 0.52);
    least = std::min(least, (moved.x - 1) * 64), most = std::max(most, (moved.x - 1) * 64);
    EXPECT_NEAR(
        glm::length(DVec3(VolumeTurn(mesh, pass, passes) * DVec4(1, 2, 3, 1)) - DVec3(1, 2, 3)), 0,
        1e-12);
  }
  EXPECT_LT(least, -0.4);
  EXPECT_GT(most, 0.4);
}

}  // namespace
}  // namespace penumbra
