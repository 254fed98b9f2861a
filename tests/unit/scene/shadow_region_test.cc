#include "render/scene/shadow_region.h"

#include <array>
#include <optional>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "render/math/random.h"
#include "render/scene/light_sample.h"

namespace penumbra {
namespace {

class Dice {
 public:
  explicit Dice(uint64_t seed) : seed_(seed) {}
  float Between(float lo, float hi) {
    return lo + (hi - lo) * static_cast<float>(UniformAt(seed_, index_++, 0));
  }
  Vec3 Point(float half) {
    const float x = Between(-half, half), y = Between(-half, half);
    return Vec3(x, y, Between(-half, half));
  }

 private:
  const uint64_t seed_;
  uint64_t index_ = 0;
};

AreaLight RandomLight(Dice& dice, int kind) {
  const Vec3 at = dice.Point(3);
  switch (kind) {
    case 0:
      return {"l", RectangleLight{.corner = at, .edge_u = dice.Point(1), .edge_v = dice.Point(1)}};
    case 1:
      return {"l",
              DiskLight{.center = at, .normal = dice.Point(1), .radius = dice.Between(0.1f, 1)}};
    case 2:
      return {"l", SphereLight{.center = at, .radius = dice.Between(0.1f, 1)}};
    case 3:
      return {"l", PointLight{.position = at}};
    case 4:
      return {"l", SpotLight{.position = at, .direction = dice.Point(1)}};
    default:
      return {"l", DistantLight{.to_light = at, .angular_diameter = dice.Between(0, 1.5f)}};
  }
}

// Whether origin + t·direction, t in [0, t_max], meets the box.
bool SegmentMeets(const Aabb& box, DVec3 origin, DVec3 direction, double t_max) {
  double t_in = 0, t_out = t_max;
  for (int axis = 0; axis < 3; ++axis) {
    double a = (box.min[axis] - origin[axis]) / direction[axis];
    double b = (box.max[axis] - origin[axis]) / direction[axis];
    if (a > b) std::swap(a, b);
    t_in = std::max(t_in, a);
    t_out = std::min(t_out, b);
  }
  return t_in <= t_out;
}

// By trying rays from a grid of receiver points to many light samples.
bool SomeRayMeets(const Aabb& box, const AreaLight& light, const Parallelogram& patch) {
  const auto samples = SampleLight(light, 100, 7, patch.At({0.5f, 0.5f}));
  constexpr int kGrid = 16;
  for (int j = 0; j <= kGrid; ++j) {
    for (int i = 0; i <= kGrid; ++i) {
      const DVec3 p(patch.At(Vec2(i, j) / static_cast<float>(kGrid)));
      for (const LightSample& sample : samples) {
        const DVec3 target(sample.point);
        const bool met = sample.at_infinity ? SegmentMeets(box, p, target, 1e6)
                                            : SegmentMeets(box, p, target - p, 1.0);
        if (met) return true;
      }
    }
  }
  return false;
}

class ShadowRegionTest : public ::testing::TestWithParam<int> {};

// Never misses a box that a ray can meet, and tells most of the others apart: what remains are
// boxes between the rays tried, and those in the corners of the square around a disc.
TEST_P(ShadowRegionTest, AgreesWithRays) {
  Dice dice(GetParam() + 1);
  int met = 0, spared = 0, doubtful = 0, spared_by_faces = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const AreaLight light = RandomLight(dice, GetParam());
    const Parallelogram patch{
        .origin = dice.Point(2), .edge_u = dice.Point(2), .edge_v = dice.Point(2)};
    Aabb box;
    const Vec3 center = dice.Point(2.5f);
    const Vec3 half = glm::abs(dice.Point(0.8f));
    box.Add(center - half);
    box.Add(center + half);

    const ShadowRegion region(light, patch);
    const bool may_meet = region.MayMeet(box);
    const Vec3 scale = Vec3(0.1f) + glm::abs(dice.Point(3)), place = dice.Point(10);
    const Affine world_from_mesh(Vec3(scale.x, 0, 0), Vec3(0, scale.y, 0), Vec3(0, 0, scale.z),
                                 place);
    const Aabb in_mesh{(box.min - place) / scale, (box.max - place) / scale};
    const ShadowRegion region_in_mesh = region.InMesh(world_from_mesh, in_mesh);
    EXPECT_TRUE(region.MayMeetByFaces(box) || !may_meet) << "trial " << trial;
    if (SomeRayMeets(box, light, patch)) {
      ++met;
      ASSERT_TRUE(may_meet) << "trial " << trial;
      ASSERT_TRUE(region_in_mesh.MayMeet(in_mesh)) << "trial " << trial;
      ASSERT_TRUE(region_in_mesh.MayMeetByFaces(in_mesh)) << "trial " << trial;
    } else {
      ++(may_meet ? doubtful : spared);
      spared_by_faces += !region_in_mesh.MayMeetByFaces(in_mesh);
    }
  }
  EXPECT_GT(met, 20);
  EXPECT_GT(spared, 100);
  EXPECT_GT(spared_by_faces, 0.8 * spared);
  EXPECT_LT(doubtful, 0.15 * (doubtful + spared));
}

INSTANTIATE_TEST_SUITE_P(EveryLight, ShadowRegionTest, ::testing::Range(0, 6));

constexpr Parallelogram kFloor{.origin = {-1, 0, 1}, .edge_u = {2, 0, 0}, .edge_v = {0, 0, -2}};

Aabb BoxAround(Vec3 center, float half) { return {center - Vec3(half), center + Vec3(half)}; }

TEST(ShadowRegionTest, DistantLightReachesUpForEverButNotDown) {
  const ShadowRegion region({"sun", DistantLight{.to_light = Vec3(0, 1, 0)}}, kFloor);
  EXPECT_TRUE(region.MayMeet(BoxAround({0, 1000, 0}, 0.1f)));
  EXPECT_FALSE(region.MayMeet(BoxAround({0, -1, 0}, 0.1f)));
  EXPECT_FALSE(region.MayMeet(BoxAround({1.2f, 1000, 0}, 0.1f)));
}

TEST(ShadowRegionTest, WhatIsBehindThePointLightCastsNothing) {
  const ShadowRegion region({"lamp", PointLight{.position = Vec3(0, 2, 0)}}, kFloor);
  EXPECT_TRUE(region.MayMeet(BoxAround({0, 1.9f, 0}, 0.05f)));
  EXPECT_FALSE(region.MayMeet(BoxAround({0, 2.1f, 0}, 0.05f)));
  // Inside the bounding box of light and floor, outside of their hull.
  EXPECT_FALSE(region.MayMeet(BoxAround({0.9f, 1.5f, 0.9f}, 0.1f)));
}

TEST(ShadowRegionTest, TouchingCountsAndEmptyDoesNot) {
  const ShadowRegion region({"lamp", PointLight{.position = Vec3(0, 2, 0)}}, kFloor);
  EXPECT_TRUE(region.MayMeet({{-5, -1, -5}, {5, 0, 5}}));
  EXPECT_FALSE(region.MayMeet(Aabb()));
}

}  // namespace
}  // namespace penumbra
