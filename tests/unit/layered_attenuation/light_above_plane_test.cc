// Closed forms against counting points.
#include "render/artifact/light_above_plane.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "render/math/basis.h"
#include "render/scene/light_sample.h"
#include "tests/support/random_scene.h"

namespace penumbra {
namespace {

using testing::Dice;

// The share of a grid of points of the unit square of which `is_above` holds.
double Counted(const std::function<bool(DVec2)>& is_above) {
  constexpr int kSide = 400;
  int above = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    above += is_above(DVec2(i % kSide + 0.5, i / kSide + 0.5) / double{kSide});
  }
  return double{static_cast<double>(above)} / (kSide * kSide);
}

// From the unit square to the unit disc, area for area: by radius and angle.
DVec2 OnDisc(DVec2 square) {
  const double angle = 2 * std::numbers::pi * square.y;
  return std::sqrt(square.x) * DVec2(std::cos(angle), std::sin(angle));
}

// Half a row of points or so.
constexpr double kError = 4e-3;

TEST(LightAbovePlaneTest, SquaresAreCutLikeTheirPoints) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    Dice dice(seed);
    const double small = seed % 3 == 0 ? 1e-6 : 1;
    const double a = dice.Between(-1, 1), b = dice.Between(-1, 1), c = small * dice.Between(-1, 1);
    const double counted = Counted([&](DVec2 p) { return a + b * p.x + c * p.y > 0; });
    EXPECT_NEAR(SquareAbove(a, b, c), counted, kError) << a << ' ' << b << ' ' << c;
    EXPECT_NEAR(SquareAbove(a, c, b), counted, kError);
  }
  EXPECT_EQ(SquareAbove(1, 0, 0), 1);
  EXPECT_EQ(SquareAbove(-1, 0, 0), 0);
  EXPECT_NEAR(SquareAbove(-0.25, 1, 0), 0.75, 1e-12);
}

TEST(LightAbovePlaneTest, DiscsAreCutLikeTheirPoints) {
  for (const double d : {-2.0, -1.0, -0.7, -0.1, 0.0, 0.3, 0.99, 1.5}) {
    EXPECT_NEAR(DiscAbove(d), Counted([&](DVec2 p) { return OnDisc(p).x > -d; }), kError) << d;
  }
}

TEST(LightAbovePlaneTest, DiscsInTheSkySetLikeTheirDirections) {
  for (const double rho : {0.005, 0.3, 0.7}) {
    for (const double part : {-1.1, -0.8, -0.2, 0.0, 0.5, 0.95, 1.2}) {
      const double h = part * rho, across = std::sqrt(1 - h * h);
      const double counted = Counted([&](DVec2 square) {
        const DVec2 d = rho * OnDisc(square);
        return across * d.x + h * std::sqrt(1 - glm::dot(d, d)) > 0;
      });
      EXPECT_NEAR(SkyDiscAbove(rho, h), counted, kError) << rho << ' ' << h;
    }
  }
}

// The sphere as the eye at the point sees it, by rays through its outline.
double SphereAbove(const SphereLight& light, DVec3 point, DVec3 normal) {
  const DVec3 to = DVec3(light.center) - point;
  const double distance = glm::length(to), radius{light.radius};
  const Basis axes = BasisAround(to);
  const double spread = radius / std::sqrt(distance * distance - radius * radius);
  return Counted([&](DVec2 square) {
    const DVec2 d = spread * OnDisc(square);
    return glm::dot(normal, axes.n + d.x * axes.s + d.y * axes.t) > 0;
  });
}

// Each kind of light, from points whose plane often cuts it.
TEST(LightAbovePlaneTest, LightsAreCutLikeTheirSamples) {
  int cut = 0;
  for (uint64_t seed = 0; seed < 600; ++seed) {
    Dice dice(seed);
    const AreaLight light = testing::RandomLight(dice, static_cast<int>(seed % 6));
    const auto samples = SampleLight(light, 1024, seed, Vec3(0.0f));
    const LightSample& aim = samples[dice.Below(static_cast<uint32_t>(samples.size()))];
    const Vec3 point = dice.InCube(2);
    // A plane through one of the samples.
    const Vec3 to = aim.at_infinity ? aim.point : aim.point - point;
    const Vec3 normal = glm::normalize(glm::cross(to, dice.Direction()));
    double expected = 0;
    if (const auto* sphere = std::get_if<SphereLight>(&light.shape)) {
      if (glm::distance(sphere->center, point) <= 1.001f * sphere->radius) continue;
      expected = SphereAbove(*sphere, DVec3(point), DVec3(normal));
    } else {
      if (samples.size() == 1) continue;  // all or nothing, by rounding
      for (const LightSample& sample : samples) {
        const Vec3 d = sample.at_infinity ? sample.point : sample.point - point;
        expected += glm::dot(d, normal) > 0 ? 1.0 / static_cast<double>(samples.size()) : 0;
      }
    }
    const float found = LightAbovePlane(light, point, normal);
    const bool is_dark_side = found == 0 && LightAbovePlane(light, point, -normal) == 0;
    if (is_dark_side) continue;  // the next test's
    cut += expected > 0.02 && expected < 0.98;
    EXPECT_NEAR(found, expected, 0.03) << "seed " << seed;
    EXPECT_NEAR(found + LightAbovePlane(light, point, -normal), 1, 1e-4) << "seed " << seed;
  }
  EXPECT_GT(cut, 200);
}

TEST(LightAbovePlaneTest, PointsAreInFrontOrBehind) {
  const AreaLight point{.id = "p", .shape = PointLight{.position = {0, 1, 0}}};
  EXPECT_EQ(LightAbovePlane(point, Vec3(3, 0, 0), Vec3(0, 1, 0)), 1);
  EXPECT_EQ(LightAbovePlane(point, Vec3(3, 0, 0), Vec3(0, -1, 0)), 0);
  const AreaLight spot{.id = "s", .shape = SpotLight{.position = {0, 1, 0}}};
  EXPECT_EQ(LightAbovePlane(spot, Vec3(3, 2, 0), Vec3(0, 1, 0)), 0);
  const AreaLight sun{.id = "d", .shape = DistantLight{.to_light = {0, 2, 0}}};
  EXPECT_EQ(LightAbovePlane(sun, Vec3(3, 2, 0), Vec3(0, 1, 0)), 1);
}

TEST(LightAbovePlaneTest, BehindALightThatShinesFromItsFrontAloneItIsDark) {
  RectangleLight rectangle{.corner = {-0.5f, 3, -0.5f}, .two_sided = false};  // shines down
  DiskLight disk{.center = {0, 3, 0}, .two_sided = false};
  for (const bool two_sided : {false, true}) {
    rectangle.two_sided = disk.two_sided = two_sided;
    for (const AreaLight& light : {AreaLight{"r", rectangle}, AreaLight{"d", disk}}) {
      EXPECT_EQ(LightAbovePlane(light, Vec3(0, 4, 0), Vec3(0, -1, 0)), two_sided ? 1 : 0);
      EXPECT_EQ(LightAbovePlane(light, Vec3(0, 2, 0), Vec3(0, 1, 0)), 1);
      EXPECT_EQ(LightAbovePlane(light, Vec3(0, 2, 0), Vec3(0, -1, 0)), 0);
      EXPECT_NEAR(LightAbovePlane(light, Vec3(0, 2, 0), Vec3(1, 0, 0)), 0.5, 1e-6);
    }
  }
}

}  // namespace
}  // namespace penumbra
