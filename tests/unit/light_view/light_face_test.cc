#include "render/light_view/light_face.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/random_scene.h"

namespace penumbra {
namespace {

using testing::Dice;

constexpr Aabb kFlatTable{.min = {-1, 0, -1}, .max = {1, 0.5f, 1}};

AreaLight Lamp(float height, bool two_sided = false) {
  return {.id = "lamp",
          .shape = RectangleLight{.corner = {-0.5f, height, -0.5f},
                                  .edge_u = {1, 0, 0},
                                  .edge_v = {0, 0, 1},
                                  .two_sided = two_sided}};
}

bool Sees(const LightFace& face, DVec3 p) {
  const DVec3 q = face.frame.FromWorld(p);
  if (!face.from_infinity && !(q.z > 0)) return false;
  const DVec2 at = face.from_infinity ? DVec2(q) : DVec2(q) / q.z;
  const DVec2 slack = 1e-6 * (face.window.size() + 1e-3);
  return glm::all(glm::greaterThanEqual(at, face.window.min - slack)) &&
         glm::all(glm::lessThanEqual(at, face.window.max + slack));
}

// Whether the light shines towards `p`, seen from its centre.
struct ShinesOn {
  DVec3 p;

  bool Before(Vec3 center, Vec3 normal, bool two_sided) const {
    const double sine = glm::dot(glm::normalize(p - DVec3(center)), glm::normalize(DVec3(normal)));
    return two_sided ? std::abs(sine) > 1e-6 : sine > 1e-6;
  }
  bool operator()(const RectangleLight& light) const {
    return Before(light.corner + 0.5f * (light.edge_u + light.edge_v),
                  glm::cross(light.edge_u, light.edge_v), light.two_sided);
  }
  bool operator()(const DiskLight& light) const {
    return Before(light.center, light.normal, light.two_sided);
  }
  bool operator()(const SpotLight& light) const {
    const DVec3 along = glm::normalize(p - DVec3(light.position));
    const double cosine = glm::dot(along, glm::normalize(DVec3(light.direction)));
    return cosine > std::cos(double{light.outer_angle}) + 1e-6;
  }
  bool operator()(const SphereLight&) const { return true; }
  bool operator()(const PointLight&) const { return true; }
  bool operator()(const DistantLight&) const { return true; }
};

bool IsLit(const AreaLight& light, DVec3 p) { return std::visit(ShinesOn{p}, light.shape); }

TEST(FacesOfTest, ALampAboveTheSceneIsOneViewDown) {
  // Its front is +u × +v = down.
  const auto faces = FacesOf(Lamp(3), kFlatTable);
  ASSERT_EQ(faces.size(), 1u);
  EXPECT_LT(glm::distance(faces[0].frame.axes.n, DVec3(0, -1, 0)), 1e-12);
  EXPECT_LT(glm::distance(faces[0].frame.origin, DVec3(0, 3, 0)), 1e-12);
  // The table's upper edge, 2.5 m below, spreads furthest.
  EXPECT_NEAR(faces[0].window.max.x, 1 / 2.5, 1e-12);
  EXPECT_NEAR(faces[0].window.min.y, -1 / 2.5, 1e-12);
  EXPECT_EQ(FacesOf(Lamp(-3), kFlatTable).size(), 0u) << "its back is dark";
  EXPECT_EQ(FacesOf(Lamp(-3, true), kFlatTable).size(), 1u);
}

TEST(FacesOfTest, AWideSceneTakesFiveAndTwiceAsManyBothWays) {
  const Aabb wide{.min = {-50, 0, -50}, .max = {50, 2, 50}};
  EXPECT_EQ(FacesOf(Lamp(3), wide).size(), 5u);
  EXPECT_EQ(FacesOf(Lamp(1, true), wide).size(), 10u);
  EXPECT_EQ(FacesOf(Lamp(3), Aabb{}).size(), 0u);
}

TEST(FacesOfTest, ASpotSeesItsConeOnly) {
  const SpotLight spot{.position = {0, 3, 0}, .outer_angle = 0.2f};
  const auto faces = FacesOf({.id = "spot", .shape = spot}, kFlatTable);
  ASSERT_EQ(faces.size(), 1u);
  EXPECT_NEAR(faces[0].window.max.x, std::tan(0.2), 1e-6);
  const SpotLight half{.position = {0, 3, 0}, .outer_angle = std::numbers::pi_v<float> / 2};
  EXPECT_EQ(FacesOf({.id = "half", .shape = half}, kFlatTable).size(), 1u);
}

// What a light shines on is in the window of a face, and of one alone but at their seams.
TEST(FacesOfTest, EveryPointBeforeTheLightIsSeen) {
  for (uint64_t seed = 0; seed < 600; ++seed) {
    Dice dice(seed);
    const AreaLight light = testing::RandomLight(dice, static_cast<int>(seed % 6));
    Aabb bounds;
    bounds.Add(dice.InCube(3));
    bounds.Add(dice.InCube(3));
    const auto faces = FacesOf(light, bounds);
    for (int i = 0; i < 20; ++i) {
      const DVec3 p(dice.Between(bounds.min.x, bounds.max.x),
                    dice.Between(bounds.min.y, bounds.max.y),
                    dice.Between(bounds.min.z, bounds.max.z));
      if (!IsLit(light, p)) continue;
      const auto seen = std::ranges::count_if(faces, [&](const auto& f) { return Sees(f, p); });
      EXPECT_EQ(seen, 1) << "seed " << seed << ", point " << p.x << ' ' << p.y << ' ' << p.z;
    }
  }
}

}  // namespace
}  // namespace penumbra
