// Shadows where they must be, and none elsewhere.
#include "gtest/gtest.h"
#include "tests/conformance/conformance.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

class ShadowTest : public ConformanceTest {};

TEST_P(ShadowTest, NoOccluderLeavesAllVisible) {
  for (const auto& [name, light] : LightsOverhead()) {
    for (const float fraction : Visibilities({.light = light, .receiver = OddFloor()})) {
      ASSERT_EQ(fraction, 1) << name;
    }
  }
}

TEST_P(ShadowTest, AFullOccluderLeavesNothing) {
  for (const auto& [name, light] : LightsOverhead()) {
    const Stage stage{.light = light,
                      .receiver = OddFloor(),
                      .occluders = {SheetOver(Vec3(0, 1, 0), Vec3(20, 1, 20))}};
    for (const float fraction : Visibilities(stage)) ASSERT_EQ(fraction, 0) << name;
  }
}

// Seen from a point 2 m up, the sheet 1 m up over x in [0, ½], z in [0.1, 0.3] shadows twice that:
// one place of a grid that a transpose or a flip would miss.
TEST_P(ShadowTest, AHardShadowLiesWhereItMust) {
  const Stage stage{.light = PointLight{.position = Vec3(0, 2, 0)},
                    .receiver = FloorReceiver("receiver", 4, 40),
                    .occluders = {SheetOver(Vec3(0.25f, 1, 0.2f), Vec3(0.25f, 1, 0.1f))}};
  const auto grid = Visibilities(stage);
  for (uint32_t j = 0; j < 40; ++j) {
    for (uint32_t i = 0; i < 40; ++i) {
      const float x = -2 + (i + 0.5f) * 0.1f, z = 2 - (j + 0.5f) * 0.1f;
      const bool dark = x > 0 && x < 1 && z > 0.2f && z < 0.6f;
      EXPECT_EQ(grid[40 * j + i], dark ? 0 : 1) << "x " << x << ", z " << z;
    }
  }
}

TEST_P(ShadowTest, WhatDoesNotCastCastsNothing) {
  Instance ghost = BoxOver(Vec3(0, 1, 0), Vec3(0.5f));
  ghost.casts = false;
  const Instance hidden = BoxOver(Vec3(0, 1, 0), Vec3(0.0f));
  const Instance behind = BoxOver(Vec3(0, 5, 0), Vec3(1.0f));
  const Instance below = BoxOver(Vec3(0, -1, 0), Vec3(0.9f));
  const Instance empty{.id = {}, .mesh = MeshOf({})};
  for (const float fraction : Visibilities({.light = PointLight{.position = Vec3(0, 2, 0)},
                              .receiver = OddFloor(),
                              .occluders = {ghost, hidden, behind, below, empty}})) {
    ASSERT_EQ(fraction, 1);
  }
}

TEST_P(ShadowTest, A15AMirroredBoxShadowsAsTheBox) {
  for (const auto& [name, light] : LightsOverhead()) {
    Stage stage{.light = light,
                .receiver = OddFloor(),
                .occluders = {BoxOver(Vec3(0.2f, 1, 0), Vec3(0.3f))}};
    const auto grid = Visibilities(stage);
    EXPECT_LT(Mean(grid), 0.99f);
    stage.occluders[0].world_from_mesh[0] *= -1;
    EXPECT_EQ(DifferingPart(Visibilities(stage), grid, 0.02f), 0) << name;
  }
}

TEST_P(ShadowTest, AMaskLetsLightThroughWhereItIsClear) {
  // Clear for u < ½, which is x < 0.
  Instance sheet = SheetOver(Vec3(0, 1, 0), Vec3(20, 1, 20));
  sheet.alpha_mask = AlphaMask::Create(2, 1, {0, 255}).value();
  const auto grid = Visibilities({.light = PointLight{.position = Vec3(0, 2, 0)},
                                  .receiver = FloorReceiver("receiver", 4, 40),
                                  .occluders = {sheet}});
  for (uint32_t t = 0; t < grid.size(); ++t) EXPECT_EQ(grid[t], t % 40 < 20 ? 1 : 0) << t;
}

// The receiver lies on an instance that casts: it does not shadow itself.
TEST_P(ShadowTest, A18ASurfaceDoesNotShadowItself) {
  Stage stage{
      .light = LightsOverhead()[0].second,
      .receiver = {.id = "receiver", .shape = PlanarInstance{"table"}, .width = 20, .height = 20}};
  Instance table = SheetOver(Vec3(1.1f, 0.7f, -0.3f), Vec3(0.9f));
  table.world_from_mesh[0] += Vec3(0, 0.31f, 0);
  table.id = "table";
  stage.occluders = {table};
  for (const float fraction : Visibilities(stage)) ASSERT_EQ(fraction, 1);
}

PENUMBRA_INSTANTIATE_CONFORMANCE(ShadowTest);

}  // namespace
}  // namespace penumbra::testing
