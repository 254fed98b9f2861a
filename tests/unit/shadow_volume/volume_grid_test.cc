#include "render/artifact/volume_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/unit/shadow_volume/depth_maps.h"

namespace penumbra {
namespace {

using testing::Dice;
using testing::MapOf;
using testing::RandomMap;
using testing::SomeView;

TEST(VolumeGridTest, CornersAreWhereTheViewHasItsPixels) {
  Dice dice(1);
  for (const bool from_infinity : {false, true}) {
    const DepthMap map = RandomMap(dice, SomeView(7, 5, from_infinity), 0);
    const VolumeGrid grid(map, VolumeBorder::kNothing, 0);
    ASSERT_EQ(grid.width(), 9u);
    ASSERT_EQ(grid.height(), 7u);
    for (uint32_t y = 0; y < 5; ++y) {
      for (uint32_t x = 0; x < 7; ++x) {
        const DVec3 expected = map.view.PointAt(DVec2(x + 0.5, y + 0.5), map.At(x, y));
        const DVec4 corner = grid.WorldAt(x + 1, y + 1);
        EXPECT_LT(glm::distance(DVec3(corner) / corner.w, expected), 1e-5);
        const auto place = grid.PlaceOf(expected);
        EXPECT_LT(glm::distance(place.at, DVec2(x + 1, y + 1)), 1e-9);
        EXPECT_NEAR(place.nearness, grid.At(x + 1, y + 1), 1e-6);
        const DVec4 by_matrix =
            grid.world_from_grid() * DVec4(x + 1, y + 1, grid.At(x + 1, y + 1), 1);
        EXPECT_LT(glm::distance(by_matrix, corner), 1e-9);
      }
    }
  }
}

TEST(VolumeGridTest, BiasIsAwayFromTheLightByPixelsWidths) {
  for (const bool from_infinity : {false, true}) {
    const LightView view = SomeView(8, 8, from_infinity);
    const DepthMap map = MapOf(view, [](uint32_t, uint32_t) { return 4.0f; });
    const VolumeGrid grid(map, VolumeBorder::kNothing, 3);
    const DVec3 at = map.view.PointAt(DVec2(2.5, 3.5), 4),
                right = map.view.PointAt(DVec2(3.5, 3.5), 4),
                up = map.view.PointAt(DVec2(2.5, 4.5), 4);
    const double pixel = std::sqrt(glm::distance(at, right) * glm::distance(at, up));
    const DVec4 corner = grid.WorldAt(3, 4);
    const DVec3 moved = DVec3(corner) / corner.w - at;
    EXPECT_NEAR(glm::dot(moved, view.frame.axes.n), 3 * pixel, 1e-5);
  }
}

TEST(VolumeGridTest, WhatIsNoDepthIsNothing) {
  const float kBad[] = {kNoDepth, NAN, -INFINITY, 0.0f, -1.0f, 1e-45f};
  const DepthMap map = MapOf(SomeView(6, 1, false), [&](uint32_t x, uint32_t) { return kBad[x]; });
  const VolumeGrid grid(map, VolumeBorder::kNothing, 1);
  for (uint32_t x = 1; x <= 6; ++x) {
    EXPECT_EQ(grid.At(x, 1), 0.0f) << x;
    EXPECT_EQ(grid.WorldAt(x, 1).w, 0.0) << x;
  }
  const DepthMap far_map =
      MapOf(SomeView(6, 1, true), [&](uint32_t x, uint32_t) { return kBad[x]; });
  const VolumeGrid far_grid(far_map, VolumeBorder::kNothing, 1);
  EXPECT_EQ(far_grid.At(1, 1), far_grid.nothing());
  EXPECT_EQ(far_grid.At(2, 1), far_grid.nothing());
  EXPECT_TRUE(std::isfinite(far_grid.At(5, 1)));
  EXPECT_EQ(far_grid.WorldAt(1, 1).w, 0.0);
}

TEST(VolumeGridTest, MapsWithoutSamplesHaveNoSurface) {
  EXPECT_FALSE(VolumeGrid(DepthMap{}, VolumeBorder::kNothing, 1).has_cells());
  EXPECT_EQ(VolumeGrid(DepthMap{}, VolumeBorder::kNothing, 1).NearnessAt(DVec2(0.5)), 0.0);
  const DepthMap one = MapOf(SomeView(1, 1, false), [](uint32_t, uint32_t) { return 2.0f; });
  const VolumeGrid ring(one, VolumeBorder::kNothing, 0);
  EXPECT_TRUE(ring.has_cells());
  EXPECT_EQ(ring.NearnessAt(DVec2(1, 1)), 0.5);
  EXPECT_FALSE(VolumeGrid(one, VolumeBorder::kOthers, 0).has_cells());
}

// Planes in the world are met where double precision says, whichever way cells are split.
TEST(VolumeGridTest, PlanesArePlane) {
  const DVec3 normal = glm::normalize(DVec3(0.3, 1, -0.2));
  for (const bool from_infinity : {false, true}) {
    const LightView view = SomeView(9, 11, from_infinity);
    const auto depth_at = [&](DVec2 pixel) {
      const DVec3 a = view.PointAt(pixel, 1), b = view.PointAt(pixel, 2);
      return 1 - glm::dot(normal, a) / glm::dot(normal, b - a);
    };
    const VolumeGrid grid(MapOf(view,
                                [&](uint32_t x, uint32_t y) {
                                  return static_cast<float>(depth_at(DVec2(x + 0.5, y + 0.5)));
                                }),
                          VolumeBorder::kNothing, 0);
    Dice dice(3);
    for (int i = 0; i < 100; ++i) {
      const DVec2 pixel(dice.Between(0.5f, 8.5f), dice.Between(0.5f, 10.5f));
      const double depth = depth_at(pixel), nearness = from_infinity ? -depth : 1 / depth;
      EXPECT_NEAR(grid.NearnessAt(pixel + 0.5), nearness, 1e-6);
    }
  }
}

TEST(VolumeGridTest, CellsAreSplitAcrossTheGreaterDifference) {
  const float kDepths[] = {1, 2, 2, 2};  // corners (0, 0), (1, 0), (0, 1), (1, 1)
  const auto grid_of = [&](int odd) {
    return VolumeGrid(MapOf(SomeView(2, 2, false),
                            [&](uint32_t x, uint32_t y) { return kDepths[(2 * y + x) ^ odd]; }),
                      VolumeBorder::kNothing, 0);
  };
  EXPECT_TRUE(grid_of(0).SplitsAtOneThree(1, 1));
  EXPECT_FALSE(grid_of(1).SplitsAtOneThree(1, 1));
  EXPECT_FALSE(grid_of(2).SplitsAtOneThree(1, 1));
  EXPECT_TRUE(grid_of(3).SplitsAtOneThree(1, 1));
  // Half of a cell whose diagonal shuts the near corner off is level.
  EXPECT_NEAR(grid_of(0).NearnessAt(DVec2(1.75, 1.75)), 0.5, 1e-6);
  EXPECT_NEAR(grid_of(0).NearnessAt(DVec2(1.25, 1.25)), 0.75, 1e-6);
}

}  // namespace
}  // namespace penumbra
