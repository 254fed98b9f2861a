// The square that stands for a light, and sets of its cells.
#include "render/technique/coherent_raytrace/light_square.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <vector>

#include "render/math/concentric_disk.h"
#include "render/scene/unoccluded_light.h"
#include "render/technique/coherent_raytrace/cell_mask.h"
#include "tests/support/random_scene.h"

namespace penumbra {
namespace {

constexpr CellGrid kFine{.side = 32, .parts = 4};

std::vector<uint32_t> PartsBehind(const LightSquare::Seen& seen,
                                  const std::vector<Vec3>& blockers) {
  std::vector<Vec4> padded(blockers.size() + kSamplerLanes, Vec4(1e9f));
  for (size_t i = 0; i < blockers.size(); ++i) padded[i] = Vec4(blockers[i], 0.0f);
  std::vector<uint32_t> parts(padded.size());
  seen.PartsBehind(kFine, padded.data(), blockers.size(), parts.data());
  parts.resize(blockers.size());
  return parts;
}

// How many parts of the fine grid `at` is from the middle of a part, along the farther axis.
float PartsApart(uint32_t part, Vec2 at) {
  const auto along = static_cast<float>(kFine.along());
  const Vec2 middle(part % kFine.along() + 0.5f, part / kFine.along() + 0.5f);
  const Vec2 apart = glm::abs(along * at - middle);
  return std::max(apart.x, apart.y);
}

// Some places of a light that a ray from the point gets to, and the ways there.
struct PlacesSeen {
  std::vector<Vec2> at;
  std::vector<Vec3> ways;
};

PlacesSeen SomePlaces(testing::Dice& dice, const AreaLight& light, Vec3 point, size_t count) {
  const LightSquare square(light);
  const LightSquare::Seen seen = square.From(point);
  PlacesSeen places;
  for (size_t tries = 0; tries < 4 * count && places.at.size() < count; ++tries) {
    const Vec2 at(dice.Between(0.02f, 0.98f), dice.Between(0.02f, 0.98f));
    const Vec3 target = seen.TargetAt(at);
    const Vec3 way = square.is_at_infinity() ? target : target - point;
    const auto* sphere = std::get_if<SphereLight>(&light.shape);
    // The ray may meet the sphere before it gets there.
    if (sphere && glm::dot(way, target - sphere->center) > -0.05f) continue;
    places.at.push_back(at);
    places.ways.push_back(way);
  }
  return places;
}

TEST(LightSquareTest, ABlockerOnTheWayToAPlaceHidesThatPlace) {
  testing::Dice dice(1);
  size_t compared = 0;
  for (int i = 0; i < 300; ++i) {
    const AreaLight light = testing::RandomLight(dice, i % testing::kLightKinds);
    const LightSquare square(light);
    if (square.is_single()) continue;
    const Vec3 point = dice.InCube(3);
    const PlacesSeen places = SomePlaces(dice, light, point, 37);  // not a number of lanes
    const auto parts_behind = [&](float from, float to) {
      std::vector<Vec3> blockers;
      for (const Vec3 way : places.ways) blockers.push_back(point + dice.Between(from, to) * way);
      return PartsBehind(square.From(point), blockers);
    };
    const std::vector<uint32_t> before = parts_behind(0.3f, 0.9f);
    for (size_t k = 0; k < before.size(); ++k, ++compared) {
      ASSERT_NE(before[k], kFine.off()) << i;
      EXPECT_LT(PartsApart(before[k], places.at[k]), 0.5f + 0.26f) << i;
    }
    for (const uint32_t part : parts_behind(-0.9f, -0.3f)) EXPECT_EQ(part, kFine.off()) << i;
    if (square.is_at_infinity()) continue;
    for (const uint32_t part : parts_behind(1.2f, 1.9f)) EXPECT_EQ(part, kFine.off()) << i;
  }
  EXPECT_GT(compared, 5000u);
}

// What the lights are, not how they are mapped.
TEST(LightSquareTest, TargetsAreOnTheLightAndReachItsEdge) {
  testing::Dice dice(6);
  const auto targets = [](const LightSquare::Seen& seen) {
    std::vector<Vec3> all;
    for (int k = 0; k <= 16; ++k) {
      for (int j = 0; j <= 16; ++j) all.push_back(seen.TargetAt(Vec2(k, j) / 16.0f));
    }
    return all;
  };
  for (int i = 0; i < 60; ++i) {
    const Vec3 point = dice.InCube(3), axis = dice.Direction(), middle = dice.InCube(2);
    const float radius = dice.Between(0.2f, 0.9f);
    float furthest = 0, highest = -1, least_cos = 1;
    const AreaLight disk{.shape = DiskLight{.center = middle, .normal = axis, .radius = radius}};
    for (const Vec3 target : targets(LightSquare(disk).From(point))) {
      EXPECT_NEAR(glm::dot(target - middle, axis), 0, 1e-5f);
      furthest = std::max(furthest, glm::distance(target, middle));
    }
    EXPECT_NEAR(furthest, radius, 1e-5f);
    const AreaLight ball{.shape = SphereLight{.center = middle, .radius = radius}};
    const Vec3 to_point = glm::normalize(point - middle);
    for (const Vec3 target : targets(LightSquare(ball).From(point))) {
      EXPECT_NEAR(glm::distance(target, middle), radius, 1e-5f);
      EXPECT_GT(glm::dot(target - middle, to_point), -1e-3f);
      highest = std::max(highest, glm::dot(target - middle, to_point));
    }
    EXPECT_NEAR(highest, radius, 1e-5f);
    const AreaLight sun{.shape = DistantLight{.to_light = axis, .angular_diameter = radius}};
    for (const Vec3 target : targets(LightSquare(sun).From(point))) {
      least_cos = std::min(least_cos, glm::dot(target, axis));
    }
    EXPECT_NEAR(std::acos(least_cos), 0.5f * radius, 1e-3f);
  }
}

TEST(LightSquareTest, ManyTargetsAreThoseOfEach) {
  testing::Dice dice(5);
  constexpr size_t kCount = 37;  // not a number of lanes
  constexpr size_t kPadded = kCount + kSamplerLanes;
  for (int i = 0; i < 500; ++i) {
    const LightSquare square(testing::RandomLight(dice, i % testing::kLightKinds));
    const LightSquare::Seen seen = square.From(dice.InCube(3));
    float u[kPadded] = {}, v[kPadded] = {}, x[kPadded], y[kPadded], z[kPadded];
    for (size_t k = 0; k < kCount; ++k) u[k] = dice.Between(0, 1), v[k] = dice.Between(0, 1);
    u[0] = v[0] = 0.5f, u[1] = v[1] = 0.0f, u[2] = 1.0f, v[2] = 0.5f;
    seen.TargetsAt(kCount, u, v, x, y, z);
    // Close to a sphere's edge rounding moves a point along it by the square root of that.
    const float near_edge =
        square.kind() == LightSquare::Kind::kSphere ? 2e-4f * square.width() : 0.0f;
    for (size_t k = 0; k < kCount; ++k) {
      const Vec3 one = seen.TargetAt({u[k], v[k]});
      EXPECT_LT(glm::distance(Vec3(x[k], y[k], z[k]), one),
                2e-6f * (1 + glm::length(one)) + near_edge)
          << i;
    }
  }
}

// Weights at the middles of side² cells of the square.
std::vector<float> WeightsOf(const LightSquare& square, Vec3 point, Vec3 normal, uint32_t side) {
  const size_t count = size_t{side} * side, padded = count + kSamplerLanes;
  std::vector<float> s(padded), t(padded), weights(padded);
  for (size_t i = 0; i < count; ++i) {
    const Vec2 place = square.PlaceOf((Vec2(i % side, i / side) + 0.5f) / float(side));
    s[i] = place.x, t[i] = place.y;
  }
  square.From(point).WeightsAt(normal, count, s.data(), t.data(), weights.data());
  weights.resize(count);
  return weights;
}

double Sum(const std::vector<float>& weights) {
  return std::accumulate(weights.begin(), weights.end(), 0.0);
}

// The mean of the weights times the size is the form factor, which is known in closed form.
TEST(LightSquareTest, WeightsIntegrateToTheFormFactor) {
  const Vec3 point(0.3f, 0, -0.2f), normal(0, 1, 0);
  const std::vector<std::pair<AreaLight, double>> lights = {
      {{.id = "r", .shape = RectangleLight{.corner = {-1, 2, -1}}}, 1.0},
      {{.id = "d", .shape = DiskLight{.center = {0, 1.5f, 0}, .radius = 0.7f}}, M_PI * 0.49},
  };
  for (const auto& [light, area] : lights) {
    const LightSquare square(light);
    const double height = square.From(point).TargetAt({0.5f, 0.5f}).y;
    constexpr uint32_t kSide = 64;
    // cos θ' is the height over the distance, which the weight leaves out as a constant.
    const double mean = Sum(WeightsOf(square, point, normal, kSide)) / (kSide * kSide);
    const double exact = UnoccludedFactor(light, DVec3(point), DVec3(normal));
    EXPECT_NEAR(mean * height * area / M_PI, exact, 2e-3 * exact) << light.id;
  }
}

// The same of round lights, also where the surface's horizon cuts them.
TEST(LightSquareTest, WeightsOfRoundLightsIntegrateToTheFormFactor) {
  const Vec3 point(0.3f, 0.1f, -0.2f);
  const SphereLight ball{.center = {0, 3, 0.5f}, .radius = 1};
  const DistantLight sun{.to_light = glm::normalize(Vec3(0.2f, 1, 0.1f)), .angular_diameter = 0.9f};
  constexpr uint32_t kSide = 256;
  for (const float tilt : {0.0f, 0.4f, 0.9f, 1.3f, 1.5f, 1.7f}) {
    const Vec3 normal(std::sin(tilt), std::cos(tilt), 0);
    const auto mean = [&](const AreaLight& light) {
      return Sum(WeightsOf(LightSquare(light), point, normal, kSide)) / (kSide * kSide);
    };
    const AreaLight near{.id = "ball", .shape = ball}, far{.id = "sun", .shape = sun};
    const double of_ball = UnoccludedFactor(near, DVec3(point), DVec3(normal));
    EXPECT_NEAR(mean(near) * ball.radius * ball.radius, of_ball, 4e-3 * of_ball + 1e-4) << tilt;
    // In shares of what falls on a surface that faces it.
    const Vec3 to_sun = sun.to_light;
    const double head_on = Sum(WeightsOf(LightSquare(far), point, to_sun, kSide)) / (kSide * kSide);
    EXPECT_NEAR(head_on, 1.0, 1e-3);
    const double of_sun = UnoccludedFactor(far, DVec3(point), DVec3(normal)) /
                          UnoccludedFactor(far, DVec3(point), DVec3(to_sun));
    EXPECT_NEAR(mean(far) / head_on, of_sun, 4e-3 * of_sun + 2e-3) << tilt;
  }
}

TEST(LightSquareTest, KnowsWhichSideOfASurfaceTheLightIsOn) {
  testing::Dice dice(2);
  using Side = LightSquare::Seen::Side;
  int counts[3] = {};
  for (int i = 0; i < 3000; ++i) {
    const LightSquare square(testing::RandomLight(dice, i % testing::kLightKinds));
    const LightSquare::Seen seen = square.From(dice.InCube(2));
    const Vec3 normal = dice.Direction();
    const Side side = seen.SideOf(normal);
    ++counts[static_cast<int>(side)];
    for (int k = 0; k < 20 && side != Side::kBoth; ++k) {
      const Vec3 target = seen.TargetAt({dice.Between(0, 1), dice.Between(0, 1)});
      EXPECT_EQ(seen.IsAbove(target, normal), side == Side::kAbove) << i;
    }
  }
  for (const int count : counts) EXPECT_GT(count, 100);
}

TEST(ConcentricDiskTest, SquareIsTheInverse) {
  testing::Dice dice(3);
  for (int i = 0; i < 1000; ++i) {
    const DVec2 at(dice.Between(0, 1), dice.Between(0, 1));
    const DVec2 back = ConcentricSquare(ConcentricDisk(at));
    EXPECT_NEAR(back.x, at.x, 1e-9);
    EXPECT_NEAR(back.y, at.y, 1e-9);
  }
}

TEST(CellMaskTest, AgreesWithSetsOfCells) {
  testing::Dice dice(4);
  for (const uint32_t side : {1u, 2u, 5u, 8u, 16u, 31u, 32u}) {
    CellMask mask(side);
    std::set<std::pair<int, int>> cells;
    for (uint32_t k = 0; k < side * side / 3 + 1; ++k) {
      const uint32_t x = dice.Below(side), y = dice.Below(side);
      mask.Add(CellMask::kMaxSide * y + x);
      cells.insert({x, y});
    }
    EXPECT_EQ(mask.Count(), cells.size());
    const CellMask dilated = mask.Dilated(), boundary = mask.Boundary();
    const CellMask exterior = CellMask::Exterior(side);
    const int n = static_cast<int>(side);
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        bool any = false, all = true;
        for (int dy = -1; dy <= 1; ++dy) {
          for (int dx = -1; dx <= 1; ++dx) {
            if (dx != 0 && dy != 0) continue;  // four neighbours
            if (x + dx < 0 || y + dy < 0 || x + dx >= n || y + dy >= n) continue;
            const bool is_in = cells.count({x + dx, y + dy}) > 0;
            any |= is_in, all &= is_in;
          }
        }
        const uint32_t cell = CellMask::kMaxSide * y + x;
        ASSERT_EQ(mask.Has(cell), cells.count({x, y}) > 0);
        EXPECT_EQ(dilated.Has(cell), any) << side;
        EXPECT_EQ(boundary.Has(cell), any && !all) << side;
        EXPECT_EQ(exterior.Has(cell), x == 0 || y == 0 || x == n - 1 || y == n - 1);
      }
    }
    std::set<std::pair<int, int>> visited;
    mask.ForEach([&](uint32_t cell) { visited.insert({cell % 32, cell / 32}); });
    EXPECT_EQ(visited, cells);
    EXPECT_EQ((CellMask::All(side) - mask).Count(), side * side - cells.size());
  }
}

}  // namespace
}  // namespace penumbra
