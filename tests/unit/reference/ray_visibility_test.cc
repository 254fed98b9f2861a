#include "render/reference/ray_visibility.h"

#include "gtest/gtest.h"
#include "render/reference/exact_ray.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

using Intersector = RayVisibility::Intersector;

std::shared_ptr<const Scene> SceneOf(Instance instance) {
  instance.id = "occluder";
  return Scene::Empty("s")->Apply({.upsert_instances = {std::move(instance)}}).value();
}

// The square [-1, 1]² on the floor, 16 × 16 texels.
ReceiverPatch Floor() {
  const Receiver receiver = FloorReceiver("floor", 2, 16);
  return {.patch = std::get<Parallelogram>(receiver.shape), .width = 16, .height = 16};
}

VisibilityMap Counts(const Scene& scene, const ReceiverPatch& receiver,
                     const std::vector<LightSample>& samples, double offset = 1e-5) {
  tbb::task_arena arena;
  return RayVisibility(scene, Intersector::kRobust).Counts(receiver, samples, offset, arena);
}

const std::vector<LightSample> kOverhead = {{.point = Vec3(0, 2, 0)}};

// A square at half the lamp's height throws a shadow of twice its size.
TEST(RayVisibilityTest, TheShadowOfASquare) {
  const auto scene = SceneOf(
      {.mesh = MeshOf(UnitSquareGeometry()), .world_from_mesh = Placed(Vec3(0, 1, 0), 0.25f)});
  const VisibilityMap map = Counts(*scene, Floor(), kOverhead);
  for (uint32_t j = 0; j < 16; ++j) {
    for (uint32_t i = 0; i < 16; ++i) {
      const bool inside = i >= 4 && i < 12 && j >= 4 && j < 12;
      EXPECT_EQ(map.At(i, j), inside ? 0 : 1) << i << ", " << j;
    }
  }
}

TEST(RayVisibilityTest, WhatIsBehindTheLightOrBelowTheFloorBlocksNothing) {
  for (const float y : {2.1f, 2.0f, -0.5f, 0.0f, 1e-6f}) {
    const auto scene = SceneOf(
        {.mesh = MeshOf(UnitSquareGeometry()), .world_from_mesh = Placed(Vec3(0, y, 0), 5.0f)});
    EXPECT_EQ(Counts(*scene, Floor(), kOverhead).At(7, 7), 1) << "at a height of " << y;
  }
}

TEST(RayVisibilityTest, TheSurfaceOffsetIsAHeight) {
  const auto scene = SceneOf(
      {.mesh = MeshOf(UnitSquareGeometry()), .world_from_mesh = Placed(Vec3(0, 0.1f, 0), 5.0f)});
  const std::vector<LightSample> slanting = {
      {.point = Vec3(1.5f, 0.5f, 0)},
      {.point = glm::normalize(Vec3(1, 0.2f, 0)), .at_infinity = true}};
  for (uint32_t s = 0; s < 2; ++s) {
    EXPECT_EQ(Counts(*scene, Floor(), {slanting[s]}, 0.099).At(3, 7), 0);
    EXPECT_EQ(Counts(*scene, Floor(), {slanting[s]}, 0.101).At(3, 7), 1);
  }
}

TEST(RayVisibilityTest, MasksLetLightThroughWhereTheyAreClear) {
  // Two texels: clear where u < ½, which is x < 0.
  const auto scene = SceneOf({.mesh = MeshOf(UnitSquareGeometry()),
                              .world_from_mesh = Placed(Vec3(0, 1, 0), 5.0f),
                              .alpha_mask = AlphaMask::Create(2, 1, {0, 255}).value()});
  const VisibilityMap map = Counts(*scene, Floor(), kOverhead);
  EXPECT_EQ(map.At(2, 7), 1);
  EXPECT_EQ(map.At(13, 7), 0);
}

TEST(RayVisibilityTest, SamplesInThePlaneAndEmptyScenesAreVisible) {
  const auto box =
      SceneOf({.mesh = MeshOf(UnitBoxGeometry()), .world_from_mesh = Placed(Vec3(0.0f))});
  const VisibilityMap map = Counts(
      *box, Floor(), {{.point = Vec3(9, 0, 0)}, {.point = Vec3(1, 0, 0), .at_infinity = true}});
  EXPECT_EQ(map.At(7, 7), 2);
  EXPECT_EQ(Counts(*Scene::Empty("s"), Floor(), kOverhead).At(7, 7), 1);
}

// Worked out by hand: a ray t · direction reaches the height h at t = h / sin(angle to the plane).
TEST(RayVisibilityTest, RaysBlockFromTheSurfaceOffsetOn) {
  const Parallelogram patch = Floor().patch;
  const auto near = [&](Vec3 point, bool at_infinity, double offset) {
    return BlockingInterval(patch, {.point = point, .at_infinity = at_infinity}, offset).near;
  };
  EXPECT_NEAR(near(Vec3(0, 1, 0), true, 0.25), 0.25, 1e-7);
  EXPECT_NEAR(near(Vec3(0.8f, 0.6f, 0), true, 0.3), 0.5, 1e-6);
  EXPECT_NEAR(near(Vec3(0, -0.6f, 0.8f), true, 0.3), 0.5, 1e-6);
  EXPECT_NEAR(near(glm::normalize(Vec3(1, 1e-3f, 0)), true, 5.0), 5e3, 1.0);
  EXPECT_NEAR(near(Vec3(7, 4, -9), false, 1.0), 0.25, 1e-7);
}

// Every ray of some small scenes, against one triangle at a time in double precision.
TEST(RayVisibilityTest, AgreesWithDoublePrecision) {
  uint64_t rays = 0, doubtful = 0, blocked_rays = 0;
  for (uint64_t seed = 0; seed < 12; ++seed) {
    const auto scene = RandomScene(seed);
    ReceiverPatch receiver = scene->ResolveReceiver("receiver").value();
    receiver.width = 13;
    receiver.height = 11;
    const auto samples =
        SampleLight(*scene->FindLight("light"), 9, seed, receiver.patch.At({0.5f, 0.5f}));
    tbb::task_arena arena;
    const RayVisibility tracer(*scene, seed % 2 == 0 ? Intersector::kRobust : Intersector::kFast);
    const auto blocked = tracer.Blocked(receiver, samples, 1e-5, arena);
    const auto counts = tracer.Counts(receiver, samples, 1e-5, arena);
    const ExactRays exact(*scene);
    for (uint32_t texel = 0; texel < 13 * 11; ++texel) {
      int visible = 0;
      const DVec3 origin(receiver.TexelCenter(texel % 13, texel / 13));
      const auto verdicts = exact.Trace(receiver.patch, origin, samples, 1e-5, 4e-6);
      for (size_t s = 0; s < samples.size(); ++s) {
        const ExactVerdict& verdict = verdicts[s];
        const bool is_blocked = blocked[s * 13 * 11 + texel] != 0;
        visible += !is_blocked;
        ++rays;
        blocked_rays += is_blocked;
        if (verdict.slack <= 4e-6) {
          ++doubtful;
        } else {
          EXPECT_EQ(is_blocked, verdict.blocked) << "scene " << seed << ", texel " << texel;
        }
      }
      EXPECT_EQ(counts.counts[texel], visible);
    }
  }
  EXPECT_LT(doubtful, rays / 100);
  EXPECT_GT(blocked_rays, rays / 20);
}

}  // namespace
}  // namespace penumbra::testing
