// What holds of attenuation LDIs whatever the scene, and scenes whose shadows are known.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "render/artifact/attenuation_ldi.h"
#include "render/artifact/light_above_plane.h"
#include "tests/support/random_scene.h"
#include "tests/unit/layered_attenuation/ldi_of.h"

namespace penumbra {
namespace {

using testing::BallGeometry;
using testing::Deviation;
using testing::Dice;
using testing::LdiOf;
using testing::Placed;
using testing::SceneOf;
using testing::Sheet;
using testing::UnitBoxGeometry;

constexpr LdiOptions kCoarse{.samples = 64, .resolution = 256};

AreaLight Lamp() {
  return {.id = "lamp",
          .shape = RectangleLight{.corner = {-0.5f, 4, -0.5f},
                                  .edge_u = {1, 0, 0},
                                  .edge_v = {0, 0, 1},
                                  .two_sided = false}};
}

std::vector<Instance> BallAndBoxes() {
  return {Sheet({0, 0, 0}, 3, 3), Placed(BallGeometry(96, 48), testing::Placed({0, 1, 0}, 0.6f)),
          Placed(UnitBoxGeometry(), testing::Placed({1.2f, 0.5f, 0.7f}, 0.4f))};
}

struct Spot {
  Vec3 point, normal;
};

// Points in the triangles of a scene, whose normals face out of closed meshes and up from sheets.
std::vector<Spot> SpotsOn(const std::vector<Instance>& instances, int count, uint64_t seed) {
  Dice dice(seed);
  std::vector<Spot> spots;
  while (static_cast<int>(spots.size()) < count) {
    const Instance& instance = instances[dice.Below(static_cast<uint32_t>(instances.size()))];
    const Mesh& mesh = *instance.mesh;
    const uint32_t t = dice.Below(static_cast<uint32_t>(mesh.triangle_count()));
    std::array<Vec3, 3> p;
    for (int k = 0; k < 3; ++k) {
      p[k] = TransformPoint(instance.world_from_mesh, mesh.positions()[mesh.indices()[3 * t + k]]);
    }
    const Vec3 across = glm::cross(p[1] - p[0], p[2] - p[0]);
    if (!(glm::length(across) > 1e-8f)) continue;
    float u = dice.Between(0, 1), v = dice.Between(0, 1);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    spots.push_back({p[0] + u * (p[1] - p[0]) + v * (p[2] - p[0]), glm::normalize(across)});
  }
  return spots;
}

TEST(PropertyTest, TheSameBitsForAnyNumberOfThreads) {
  for (const bool key_views : {false, true}) {
    const auto scene = SceneOf(BallAndBoxes());
    LdiOptions options = kCoarse;
    options.key_views = key_views;
    const AttenuationLdi one = LdiOf(*scene, Lamp(), options, 1);
    for (const int threads : {2, 4}) {
      const AttenuationLdi many = LdiOf(*scene, Lamp(), options, threads);
      ASSERT_EQ(many.faces.size(), one.faces.size());
      EXPECT_EQ(many.faces[0].offsets, one.faces[0].offsets);
      EXPECT_EQ(many.faces[0].depths, one.faces[0].depths);
      EXPECT_EQ(many.faces[0].counts, one.faces[0].counts);
    }
  }
}

// Scene and light turned, moved and made larger.
TEST(PropertyTest, RigidMotionAndScaleChangeNothing) {
  const auto instances = BallAndBoxes();
  const AttenuationLdi ldi = LdiOf(*SceneOf(instances), Lamp(), kCoarse);
  const auto spots = SpotsOn(instances, 4000, 1);
  const float c = std::cos(0.7f), s = std::sin(0.7f);
  const glm::mat3 turn =
      glm::mat3(c, s, 0, -s, c, 0, 0, 0, 1) * glm::mat3(1, 0, 0, 0, c, s, 0, -s, c);
  for (const float scale : {1.0f, 37.0f, 0.01f}) {
    const Vec3 move = scale * Vec3(3, -2, 5);
    const Affine to(scale * turn[0], scale * turn[1], scale * turn[2], move);
    auto moved = instances;
    for (Instance& instance : moved) {
      const Affine& from = instance.world_from_mesh;
      const glm::mat3 linear = scale * turn * glm::mat3(from);
      instance.world_from_mesh =
          Affine(linear[0], linear[1], linear[2], TransformPoint(to, from[3]));
    }
    AreaLight light = Lamp();
    auto& rectangle = std::get<RectangleLight>(light.shape);
    rectangle.corner = TransformPoint(to, rectangle.corner);
    rectangle.edge_u = scale * turn * rectangle.edge_u;
    rectangle.edge_v = scale * turn * rectangle.edge_v;
    const AttenuationLdi there = LdiOf(*SceneOf(moved), light, kCoarse);
    Deviation off;
    for (const Spot& spot : spots) {
      off.Add(Visibility(there, TransformPoint(to, spot.point), turn * spot.normal),
              Visibility(ldi, spot.point, spot.normal));
    }
    EXPECT_GT(off.partly_lit(), 300);
    EXPECT_LT(off.mean(), 0.012) << scale;
  }
}

TEST(PropertyTest, AnotherOccluderBrightensNothing) {
  auto instances = BallAndBoxes();
  const auto spots = SpotsOn(instances, 4000, 2);
  const AttenuationLdi before = LdiOf(*SceneOf(instances), Lamp(), kCoarse);
  instances.push_back(Sheet({0.5f, 2, 0}, 0.4f, 0.5f));
  const AttenuationLdi after = LdiOf(*SceneOf(instances), Lamp(), kCoarse);
  double brighter = 0, darker = 0;
  for (const Spot& spot : spots) {
    const double change =
        Visibility(after, spot.point, spot.normal) - Visibility(before, spot.point, spot.normal);
    brighter += std::max(0.0, change) / 4000;
    darker += std::max(0.0, -change) / 4000;
  }
  EXPECT_GT(darker, 0.05);
  // The image's pixels fall elsewhere, for the sheet may change the window.
  EXPECT_LT(brighter, 0.003);
}

// A ball alone hides from a point of it what is below the point's horizon, and nothing else.
TEST(PropertyTest, ABallShadowsItself) {
  const std::vector<Instance> ball = {
      Placed(BallGeometry(128, 64), testing::Placed({0, 1, 0}, 0.6f))};
  for (const AreaLight& light :
       {Lamp(), AreaLight{.id = "s", .shape = SphereLight{.center = {0.5f, 4, 0}, .radius = 1}}}) {
    const AttenuationLdi ldi = LdiOf(*SceneOf(ball), light, {.samples = 64, .resolution = 256});
    Deviation off;
    for (const Spot& spot : SpotsOn(ball, 4000, 3)) {
      off.Add(Visibility(ldi, spot.point, spot.normal),
              LightAbovePlane(light, spot.point, spot.normal));
    }
    EXPECT_GT(off.partly_lit(), 200);
    EXPECT_LT(off.mean(), 0.012);
  }
}

// Six walls around a sphere light, before each a sheet that covers one half.
TEST(PropertyTest, ASphereShinesAllAround) {
  constexpr float kRadius = 0.4f, kWall = 3, kSheet = 2;
  const AreaLight light{.id = "s", .shape = SphereLight{.radius = kRadius}};
  const std::array<glm::mat3, 6> turns = {
      glm::mat3(1, 0, 0, 0, 1, 0, 0, 0, 1),  glm::mat3(1, 0, 0, 0, -1, 0, 0, 0, -1),
      glm::mat3(0, 1, 0, -1, 0, 0, 0, 0, 1), glm::mat3(0, -1, 0, 1, 0, 0, 0, 0, 1),
      glm::mat3(1, 0, 0, 0, 0, 1, 0, -1, 0), glm::mat3(1, 0, 0, 0, 0, -1, 0, 1, 0)};
  std::vector<Instance> instances;
  for (const glm::mat3& turn : turns) {
    for (const auto& [center, half_x, half_z] :
         {std::tuple{Vec3(0, -kWall, 0), kWall, kWall}, {Vec3(-0.75f, -kSheet, 0), 0.75f, 1.5f}}) {
      instances.push_back(
          Placed(testing::UnitSquareGeometry(),
                 Affine(half_x * turn[0], turn[1], half_z * turn[2], turn * center)));
    }
  }
  const AttenuationLdi ldi = LdiOf(*SceneOf(instances), light, {.samples = 100, .resolution = 128});
  ASSERT_EQ(ldi.faces.size(), 6u);
  for (const glm::mat3& turn : turns) {
    Deviation off;
    for (float x = -0.5f; x <= 0.5f; x += 0.007f) {
      const DVec3 p(x, -kWall, 0.3), to_edge = DVec3(0, -kSheet, 0) - DVec3(p.x, p.y, 0);
      // The plane through the point and the edge, along z: how far the centre is to its lit side.
      const double beyond = (to_edge.y * -p.x - to_edge.x * -p.y) / glm::length(to_edge);
      const double distance = glm::length(p);
      const double sine = beyond / distance, spread = kRadius / distance;
      const double d = sine / std::sqrt(1 - sine * sine) * std::sqrt(1 - spread * spread) / spread;
      const double cut = std::clamp(d, -1.0, 1.0);
      const double part = 1 - (std::acos(cut) - cut * std::sqrt(1 - cut * cut)) / std::numbers::pi;
      off.Add(Visibility(ldi, turn * Vec3(p), turn * Vec3(0, 1, 0)), part);
    }
    EXPECT_GT(off.partly_lit(), 30);
    EXPECT_LT(off.mean(), 0.02);
    EXPECT_LT(off.most(), 0.12);
  }
}

TEST(PropertyTest, ALightInABoxShinesOnItsInsideAlone) {
  const std::vector<Instance> instances = {
      Sheet({0, -2, 0}, 3, 3), Placed(UnitBoxGeometry(), testing::Placed({0, 0, 0}, 1.0f))};
  const AreaLight light{.id = "s", .shape = SphereLight{.radius = 0.2f}};
  const AttenuationLdi ldi = LdiOf(*SceneOf(instances), light, {.samples = 16, .resolution = 128});
  for (float x = -0.9f; x < 0.95f; x += 0.1f) {
    EXPECT_EQ(Visibility(ldi, Vec3(x, -1, 0.3f), Vec3(0, 1, 0)), 1) << x;
    EXPECT_EQ(Visibility(ldi, Vec3(x, -1, 0.3f), Vec3(0, -1, 0)), 0) << "the outside";
    EXPECT_EQ(Visibility(ldi, Vec3(x, -2, 0.3f), Vec3(0, 1, 0)), 0) << "the floor";
    EXPECT_EQ(Visibility(ldi, Vec3(3 * x, 0.3f, 1), Vec3(0, 0, -1)), std::abs(3 * x) < 1 ? 1 : 0);
  }
}

TEST(PropertyTest, WhatIsCloseToTheLightStillHidesIt) {
  // A four-hundredth of the way to the floor.
  const auto scene = SceneOf({Sheet({0, 0, 0}, 3, 3), Sheet({0, 3.99f, 0}, 0.6f, 0.6f)});
  const AttenuationLdi ldi = LdiOf(*scene, Lamp(), {.samples = 16, .resolution = 128});
  for (float x = -2; x <= 2; x += 0.1f) EXPECT_EQ(Visibility(ldi, Vec3(x, 0, 0.2f), {0, 1, 0}), 0);
}

TEST(PropertyTest, WithoutOccludersAllIsLit) {
  const AttenuationLdi ldi = LdiOf(*Scene::Empty("s"), Lamp());
  EXPECT_TRUE(ldi.faces.empty());
  EXPECT_EQ(Visibility(ldi, Vec3(0), Vec3(0, 1, 0)), 1);
  EXPECT_EQ(Visibility(ldi, Vec3(0), Vec3(0, -1, 0)), 0);
  EXPECT_EQ(Visibility(ldi, Vec3(NAN, 0, 0), Vec3(0, 1, 0)), 0);
}

}  // namespace
}  // namespace penumbra
