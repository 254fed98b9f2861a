#include "render/technique/soft_texture/receiver_transform.h"

#include <gtest/gtest.h>

#include <random>

namespace penumbra {
namespace {

class ReceiverTransformTest : public ::testing::Test {
 protected:
  Vec3 RandomPoint(float size) {
    std::uniform_real_distribution<float> u(-size, size);
    return {u(random_), u(random_), u(random_)};
  }
  Parallelogram RandomPatch() { return {RandomPoint(5), RandomPoint(3), RandomPoint(3)}; }

  std::mt19937 random_{7};
};

// The definition, in Herf 1997 §3.2: what x, y and w are at the apex and at three corners of the
// base.
TEST_F(ReceiverTransformTest, TakesThePyramidsCornersWhereTheyBelong) {
  for (int trial = 0; trial < 200; ++trial) {
    const Parallelogram patch = RandomPatch();
    const LightSample sample{.point = RandomPoint(8)};
    const auto map = ReceiverTransform::Create(patch, sample, 1e-3);
    if (!map) continue;
    const DVec3 b(patch.origin), e_x(patch.edge_u), e_y(patch.edge_v);
    const double tolerance = 1e-9 / std::abs(map->sample_height());
    const auto expect = [&](DVec3 p, DVec3 xyw) {
      EXPECT_LT(glm::length(map->FromWorld(p) - xyw), 100 * tolerance);
    };
    expect(b, {0, 0, 1});
    expect(b + e_x, {1, 0, 1});
    expect(b + e_y, {0, 1, 1});
    expect(DVec3(sample.point), {0, 0, 0});
  }
}

// The second derivation: u and v of a point's shadow by intersecting the line from the light with
// the plane.
TEST_F(ReceiverTransformTest, ProjectsLikeALineFromTheLight) {
  for (const bool at_infinity : {false, true}) {
    for (int trial = 0; trial < 200; ++trial) {
      const Parallelogram patch = RandomPatch();
      const Vec3 point = at_infinity ? glm::normalize(RandomPoint(1)) : RandomPoint(8);
      const auto map =
          ReceiverTransform::Create(patch, {.point = point, .at_infinity = at_infinity}, 1e-2);
      if (!map) continue;
      const DVec3 p(RandomPoint(6));
      const DVec3 direction = at_infinity ? -DVec3(point) : p - DVec3(point);
      // p + t·direction = origin + u·e_x + v·e_y
      const glm::dmat3 system(DVec3(patch.edge_u), DVec3(patch.edge_v), -direction);
      if (std::abs(glm::determinant(system)) < 1e-2) continue;
      const DVec3 uvt = glm::inverse(system) * (p - DVec3(patch.origin));
      const DVec3 xyw = map->FromWorld(p);
      EXPECT_NEAR(xyw.x / xyw.z, uvt.x, 1e-6 * (1 + std::abs(uvt.x)));
      EXPECT_NEAR(xyw.y / xyw.z, uvt.y, 1e-6 * (1 + std::abs(uvt.y)));
      if (at_infinity) {
        EXPECT_EQ(xyw.z, 1.0);
      }
    }
  }
}

TEST_F(ReceiverTransformTest, SaysOnWhichSideTheLightIs) {
  const Parallelogram floor{.origin = Vec3(0), .edge_u = Vec3(1, 0, 0), .edge_v = Vec3(0, 0, -1)};
  EXPECT_DOUBLE_EQ(
      ReceiverTransform::Create(floor, {.point = Vec3(0, 3, 0)}, 0.01)->sample_height(), 3.0);
  EXPECT_DOUBLE_EQ(
      ReceiverTransform::Create(floor, {.point = Vec3(0, -2, 0)}, 0.01)->sample_height(), -2.0);
  EXPECT_GT(ReceiverTransform::Create(floor, {.point = Vec3(0, 1, 0), .at_infinity = true}, 0.01)
                ->sample_height(),
            1e300);
}

TEST_F(ReceiverTransformTest, HasNoPyramidForALightInThePlane) {
  const Parallelogram floor{.origin = Vec3(0), .edge_u = Vec3(1, 0, 0), .edge_v = Vec3(0, 0, -1)};
  EXPECT_FALSE(ReceiverTransform::Create(floor, {.point = Vec3(5, 1e-6f, 0)}, 1e-5));
  EXPECT_FALSE(
      ReceiverTransform::Create(floor, {.point = Vec3(1, 0, 0), .at_infinity = true}, 1e-5));
}

// Far from the origin occluders near the plane do not count; that says nothing of the sun's angle.
TEST_F(ReceiverTransformTest, ALowSunHasAPyramidHoweverThickThePlane) {
  const Parallelogram floor{
      .origin = Vec3(5e6f, 0, 0), .edge_u = Vec3(9, 0, 0), .edge_v = Vec3(0, 0, -9)};
  const LightSample low_sun{.point = glm::normalize(Vec3(1, 1e-3f, 0)), .at_infinity = true};
  EXPECT_TRUE(ReceiverTransform::Create(floor, low_sun, 9.5));
}

}  // namespace
}  // namespace penumbra
