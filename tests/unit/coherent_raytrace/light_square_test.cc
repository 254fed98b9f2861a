// The square that stands for a light, and sets of its cells.
#include "render/technique/coherent_raytrace/light_square.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

#include "render/math/concentric_disk.h"
#include "render/scene/unoccluded_light.h"
#include "render/technique/coherent_raytrace/cell_mask.h"
#include "tests/support/random_scene.h"

namespace penumbra {
namespace {

TEST(LightSquareTest, ABlockerOnTheWayToAPlaceHidesThatPlace) {
  testing::Dice dice(1);
  size_t compared = 0;
  for (int i = 0; i < 6000; ++i) {
    const AreaLight light = testing::RandomLight(dice, i % testing::kLightKinds);
    const LightSquare square(light);
    if (square.is_single()) continue;
    const Vec3 point = dice.InCube(3);
    const LightSquare::Seen seen = square.From(point);
    const Vec2 at(dice.Between(0.02f, 0.98f), dice.Between(0.02f, 0.98f));
    const Vec3 target = seen.TargetAt(at);
    const Vec3 way = square.is_at_infinity() ? target : target - point;
    if (square.kind() == LightSquare::Kind::kSphere &&
        glm::dot(way, target - std::get<SphereLight>(light.shape).center) > -0.05f) {
      continue;  // the ray meets the sphere before it gets there
    }
    const Vec3 blocker = point + dice.Between(0.3f, 0.9f) * way;
    const Vec2 found = seen.SquareOf(blocker);
    ++compared;
    EXPECT_NEAR(found.x, at.x, 2e-3f) << i;
    EXPECT_NEAR(found.y, at.y, 2e-3f) << i;
    if (!square.is_at_infinity()) {
      EXPECT_EQ(seen.SquareOf(point + 1.5f * way), Vec2(LightSquare::kOutside)) << "behind, " << i;
    }
    EXPECT_EQ(seen.SquareOf(point - 0.5f * way), Vec2(LightSquare::kOutside)) << "away, " << i;
  }
  EXPECT_GT(compared, 2500u);
}

// The mean of the weights times the size is the form factor, which is known in closed form.
TEST(LightSquareTest, WeightsIntegrateToTheFormFactor) {
  const Vec3 point(0.3f, 0, -0.2f), normal(0, 1, 0);
  const std::vector<std::pair<AreaLight, double>> lights = {
      {{.id = "r", .shape = RectangleLight{.corner = {-1, 2, -1}}}, 1.0},
      {{.id = "d", .shape = DiskLight{.center = {0, 1.5f, 0}, .radius = 0.7f}}, M_PI * 0.49},
  };
  for (const auto& [light, area] : lights) {
    const LightSquare::Seen seen = LightSquare(light).From(point);
    double sum = 0, height = seen.TargetAt({0.5f, 0.5f}).y;
    constexpr int kSide = 64;
    for (int i = 0; i < kSide * kSide; ++i) {
      sum += seen.WeightAt((Vec2(i % kSide, i / kSide) + 0.5f) / float(kSide), normal);
    }
    // cos θ' is the height over the distance, which the weight leaves out as a constant.
    const double factor = sum / (kSide * kSide) * height * area / M_PI;
    const double exact = UnoccludedFactor(light, DVec3(point), DVec3(normal));
    EXPECT_NEAR(factor, exact, 2e-3 * exact) << light.id;
  }
}

// Of a sphere and of the sky, weights of halves of the light compare as their irradiances do.
TEST(LightSquareTest, SphereWeightsAreThoseOfSolidAngle) {
  const AreaLight light{.id = "s", .shape = SphereLight{.center = {0, 4, 0}, .radius = 1}};
  const Vec3 point(0.0f), normal = glm::normalize(Vec3(1, 1, 0));
  const LightSquare::Seen seen = LightSquare(light).From(point);
  double sum = 0, tilted = 0;
  constexpr int kSide = 256;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec2 at = (Vec2(i % kSide, i / kSide) + 0.5f) / float(kSide);
    sum += seen.WeightAt(at, Vec3(0, 1, 0));
    tilted += seen.WeightAt(at, normal);
  }
  const double head_on = UnoccludedFactor(light, DVec3(point), DVec3(0, 1, 0));
  const double exact = UnoccludedFactor(light, DVec3(point), DVec3(normal));
  EXPECT_NEAR(tilted / sum, exact / head_on, 0.01);
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
