#include "render/scene/light_sample.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <random>

namespace penumbra {
namespace {

AreaLight UnitSquare() {
  return {
      .id = "square",
      .shape = RectangleLight{.corner = Vec3(0), .edge_u = Vec3(1, 0, 0), .edge_v = Vec3(0, 1, 0)}};
}

// Area of the part of the unit square with normal · p > offset, by cutting the square.
double AreaInFront(DVec2 normal, double offset) {
  const std::array<DVec2, 4> corners = {DVec2(0, 0), DVec2(1, 0), DVec2(1, 1), DVec2(0, 1)};
  std::vector<DVec2> kept;
  for (size_t i = 0; i < 4; ++i) {
    const DVec2 a = corners[i], b = corners[(i + 1) % 4];
    const double da = glm::dot(normal, a) - offset, db = glm::dot(normal, b) - offset;
    if (da > 0) kept.push_back(a);
    if ((da > 0) != (db > 0)) kept.push_back(a + da / (da - db) * (b - a));
  }
  double twice = 0;
  for (size_t i = 0; i < kept.size(); ++i) {
    const DVec2 a = kept[i], b = kept[(i + 1) % kept.size()];
    twice += a.x * b.y - a.y * b.x;
  }
  return 0.5 * twice;
}

TEST(SampleLight, PutsOneSampleInEachCell) {
  for (const uint32_t side : {1u, 2u, 8u, 16u, 32u}) {
    std::map<std::pair<int, int>, int> hits;
    for (const LightSample& s : SampleLight(UnitSquare(), side * side, 3, Vec3(0))) {
      ++hits[{static_cast<int>(s.point.x * side), static_cast<int>(s.point.y * side)}];
      EXPECT_FLOAT_EQ(s.weight, 1.0f / (side * side));
    }
    EXPECT_EQ(hits.size(), side * side);
  }
}

// For any n, however awkward, the mean of x, y, x² and xy is right to a stratified sample's error.
TEST(SampleLight, IsUnbiasedForEveryCount) {
  for (uint32_t n = 1; n <= 1024; n = n < 20 ? n + 1 : n + 37) {
    const auto samples = SampleLight(UnitSquare(), n, 1, Vec3(0));
    ASSERT_EQ(samples.size(), n);
    double x = 0, y = 0, xx = 0, xy = 0;
    for (const LightSample& s : samples) {
      ASSERT_TRUE(s.point.x >= 0 && s.point.x <= 1 && s.point.y >= 0 && s.point.y <= 1);
      x += s.point.x;
      y += s.point.y;
      xx += s.point.x * s.point.x;
      xy += s.point.x * s.point.y;
    }
    const double tolerance = 1.5 / n + 0.05 * (n < 4);
    EXPECT_NEAR(x / n, 0.5, tolerance) << n;
    EXPECT_NEAR(y / n, 0.5, tolerance) << n;
    EXPECT_NEAR(xx / n, 1.0 / 3, tolerance) << n;
    EXPECT_NEAR(xy / n, 0.25, tolerance) << n;
  }
}

// The first k of 64 samples lie in k different cells of any coarser grid that has at least 2k of
// them.
TEST(SampleLight, SpreadsEveryPrefix) {
  const auto samples = SampleLight(UnitSquare(), 64, 1, Vec3(0));
  double nearest = 1;
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < i; ++j) {
      nearest = std::min<double>(nearest, glm::length(samples[i].point - samples[j].point));
    }
  }
  // Eight points cannot be further apart than 0.52 in a unit square; a random set has about 0.1.
  EXPECT_GT(nearest, 0.25);
}

TEST(SampleLight, IsAFunctionOfItsArguments) {
  EXPECT_EQ(SampleLight(UnitSquare(), 50, 4, Vec3(1)), SampleLight(UnitSquare(), 50, 4, Vec3(1)));
  EXPECT_NE(SampleLight(UnitSquare(), 50, 4, Vec3(1)), SampleLight(UnitSquare(), 50, 5, Vec3(1)));
}

// When the light moves, its samples move with it: no flicker.
TEST(SampleLight, MovesWithTheLight) {
  AreaLight moved = UnitSquare();
  std::get<RectangleLight>(moved.shape).corner = Vec3(3, 2, 1);
  const auto before = SampleLight(UnitSquare(), 64, 1, Vec3(0));
  const auto after = SampleLight(moved, 64, 1, Vec3(0));
  for (size_t i = 0; i < before.size(); ++i) {
    EXPECT_LT(glm::length(after[i].point - before[i].point - Vec3(3, 2, 1)), 1e-6f);
  }
}

// Dragged all around and turned over, every light's samples follow it by small steps; only a lamp
// that shines straight up, or lies straight below the patch, may turn its grid at once.
TEST(SampleLight, DoesNotJumpWhileALightIsDragged) {
  const auto at = [](int step) {
    const double a = 2 * std::numbers::pi * step / 1000;
    return Vec3(DVec3(3 * std::cos(a), 2 + 1.5 * std::sin(3 * a), 3 * std::sin(a)));
  };
  const std::array<std::function<LightShape(Vec3)>, 3> lights = {
      [](Vec3 p) { return SphereLight{.center = p, .radius = 0.5f}; },
      [](Vec3 p) { return DiskLight{.center = p, .normal = -p, .radius = 0.5f}; },
      [](Vec3 p) { return DistantLight{.to_light = p, .angular_diameter = 0.3f}; }};
  for (size_t kind = 0; kind < lights.size(); ++kind) {
    const auto samples = [&](int step) {
      return SampleLight({.id = "l", .shape = lights[kind](at(step))}, 64, 1, Vec3(0));
    };
    auto before = samples(0);
    for (int step = 1; step <= 1000; ++step) {
      const auto after = samples(step);
      const float moved = glm::distance(at(step), at(step - 1));
      for (size_t i = 0; i < before.size(); ++i) {
        ASSERT_LT(glm::distance(after[i].point, before[i].point), 2 * moved)
            << "light " << kind << ", step " << step << ", sample " << i;
      }
      before = after;
    }
  }
}

// A straight edge across the square: how well the first k of n samples tell the part in front of
// it, against a grid made for k and against k samples strewn about.
TEST(SampleLight, EveryPrefixMeasuresAlmostAsWellAsAGridOfItsOwn) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (const uint32_t k : {8u, 16u, 32u, 64u, 128u}) {
    double prefix2 = 0, own2 = 0, strewn2 = 0;
    constexpr int kEdges = 2000;
    for (int edge = 0; edge < kEdges; ++edge) {
      const double angle = 2 * std::numbers::pi * uniform(random);
      const DVec2 normal(std::cos(angle), std::sin(angle));
      const double offset = glm::dot(normal, DVec2(uniform(random), uniform(random)));
      const auto seed = static_cast<uint64_t>(edge);
      const double area = AreaInFront(normal, offset);
      const auto error = [&](const std::vector<LightSample>& samples) {
        double in_front = 0;
        for (uint32_t i = 0; i < k; ++i) {
          const Vec3 p = samples[i].point;
          in_front += normal.x * p.x + normal.y * p.y > offset;
        }
        return in_front / k - area;
      };
      prefix2 += std::pow(error(SampleLight(UnitSquare(), 256, seed, Vec3(0))), 2);
      own2 += std::pow(error(SampleLight(UnitSquare(), k, seed, Vec3(0))), 2);
      strewn2 += area * (1 - area) / k;
    }
    EXPECT_LT(std::sqrt(prefix2 / own2), 1.25) << "of a grid's own error, k = " << k;
    EXPECT_LT(std::sqrt(prefix2 / strewn2), 0.6) << "of a random set's error, k = " << k;
  }
}

TEST(SampleLight, StaysOnTheDiskAndFillsIt) {
  const DiskLight disk{.center = Vec3(1, 2, 3), .normal = Vec3(0, 2, 1), .radius = 0.5f};
  double second_moment = 0;
  const auto samples = SampleLight({.id = "d", .shape = disk}, 1024, 1, Vec3(0));
  for (const LightSample& s : samples) {
    const Vec3 d = s.point - disk.center;
    EXPECT_NEAR(glm::dot(d, disk.normal), 0, 1e-6);
    EXPECT_LE(glm::length(d), 0.5f + 1e-6f);
    second_moment += glm::dot(d, d);
  }
  EXPECT_NEAR(second_moment / 1024, 0.5 * 0.25, 1e-3);  // ∫ r² dA / A = R²/2
}

TEST(SampleLight, FillsTheHalfOfTheSphereThatTheTargetSees) {
  const SphereLight sphere{.center = Vec3(0, 5, 0), .radius = 2};
  double across = 0;
  for (const LightSample& s : SampleLight({.id = "s", .shape = sphere}, 1024, 1, Vec3(0))) {
    EXPECT_NEAR(glm::length(s.point - sphere.center), 2, 1e-5);
    EXPECT_LE(s.point.y, 5 + 1e-5);
    across += s.point.x * s.point.x + s.point.z * s.point.z;
  }
  EXPECT_NEAR(across / 1024, 2.0, 1e-2);
}

TEST(SampleLight, GivesDirectionsForTheSun) {
  const DistantLight sun{.to_light = Vec3(0, 3, 0), .angular_diameter = 0.2f};
  float widest = 0;
  for (const LightSample& s : SampleLight({.id = "sun", .shape = sun}, 256, 1, Vec3(0))) {
    EXPECT_TRUE(s.at_infinity);
    EXPECT_NEAR(glm::length(s.point), 1, 1e-6);
    widest = std::max(widest, std::acos(s.point.y));
  }
  EXPECT_LE(widest, 0.1f + 1e-4f);
  EXPECT_GT(widest, 0.09f);
  const DistantLight pin{.to_light = Vec3(0, 3, 0)};
  EXPECT_EQ(SampleLight({.id = "pin", .shape = pin}, 64, 1, Vec3(0)).size(), 1u);
  EXPECT_EQ(SampleLight({.id = "p", .shape = PointLight{}}, 64, 1, Vec3(0)).size(), 1u);
}

}  // namespace
}  // namespace penumbra
