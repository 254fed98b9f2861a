// Receivers that do not fill their patch, computed.
#include <gtest/gtest.h>

#include "render/scene/receiver_place.h"
#include "tests/unit/technique/soft_texture_scenes.h"

namespace penumbra {
namespace {

using testing::Compute;
using testing::TextureOf;

// A box stands on the part of the floor's patch that an L leaves out: under it all is dark, and
// none of that may come near the L.
SceneDelta LAroundABox() {
  SceneDelta delta;
  delta.upsert_instances = {{.id = "box",
                             .mesh = testing::MeshOf(testing::UnitBoxGeometry()),
                             .world_from_mesh = testing::Placed(Vec3(1.5f, 0.1f, 1.5f), 0.499f)}};
  delta.upsert_lights = {{.id = "light", .shape = DistantLight{.to_light = Vec3(0, 1, 0)}}};
  delta.upsert_receivers = {
      {.id = "floor",
       .shape = PlanarPolygon{{{0, 0, 0}, {0, 0, 2}, {1, 0, 2}, {1, 0, 1}, {2, 0, 1}, {2, 0, 0}}},
       .width = 64,
       .height = 64}};
  return delta;
}

TEST(ReceiverCoverage, WhatLiesOutsideIsNotSeenInside) {
  const auto artifact = Compute(*testing::SceneOf(LAroundABox()));
  ASSERT_TRUE(artifact.ok()) << artifact.status();
  const SoftShadowTexture& texture = TextureOf(*artifact);
  ASSERT_NE(texture.coverage, nullptr);
  EXPECT_EQ(texture.coverage->CountInside(), 64u * 64 * 3 / 4);
  EXPECT_EQ(texture.receiver.region, nullptr) << "the mask says it";
  size_t gutter = 0, beyond = 0;
  for (uint32_t j = 0; j < 64; ++j) {
    for (uint32_t i = 0; i < 64; ++i) {
      const Vec3 p = texture.receiver.TexelCenter(i, j);
      EXPECT_EQ(Covers(*artifact, p), !(p.x > 1 && p.z > 1));
      const double off = std::min(p.x, p.z) - 1;  // from the L, in metres of 32 texels
      const bool is_repeated = off * 32 < 15.9;
      if (is_repeated) {
        EXPECT_EQ(texture.visibility.At(i, j), 1) << i << " " << j;
      } else if (off * 32 > 16.6) {
        EXPECT_EQ(texture.visibility.At(i, j), 0) << i << " " << j;
      }
      if (off > 0) ++(is_repeated ? gutter : beyond);
    }
  }
  EXPECT_GT(gutter, 100u);
  EXPECT_GT(beyond, 100u);
}

TEST(ReceiverCoverage, InsideCountsAreThoseOfTheWholePatch) {
  SceneDelta delta = testing::RandomBoxes(15, 4);
  delta.upsert_lights = {testing::Ceiling()};
  delta.upsert_receivers = {{.id = "floor",
                             .shape = Triangle{{-3, 0, 3}, {6, 0, 0}, {0, 0, -6}},
                             .width = 70,
                             .height = 50}};
  const auto half = Compute(*testing::SceneOf(delta));
  delta.upsert_receivers[0].shape = Parallelogram{{-3, 0, 3}, {6, 0, 0}, {0, 0, -6}};
  const auto whole = Compute(*testing::SceneOf(delta));
  ASSERT_TRUE(half.ok() && whole.ok());
  EXPECT_EQ(TextureOf(*whole).coverage, nullptr);
  for (uint32_t j = 0; j < 50; ++j) {
    for (uint32_t i = 0; i < 70; ++i) {
      if (!TextureOf(*half).coverage->At(i, j)) continue;
      ASSERT_EQ(TextureOf(*half).visibility.At(i, j), TextureOf(*whole).visibility.At(i, j));
    }
  }
}

// A surface that is not quite flat must not shadow its own patch.
TEST(ReceiverCoverage, AnUnevenSurfaceDoesNotShadowItself) {
  MeshGeometry uneven;
  for (int j = 0; j <= 8; ++j) {
    for (int i = 0; i <= 8; ++i) {
      uneven.positions.emplace_back(0.5f * i - 2, (i * 7 + j * 5) % 3 * 2e-5f, 2 - 0.5f * j);
    }
  }
  for (uint32_t j = 0; j < 8; ++j) {
    for (uint32_t i = 0; i < 8; ++i) {
      const uint32_t a = 9 * j + i;
      uneven.indices.insert(uneven.indices.end(), {a, a + 1, a + 10, a, a + 10, a + 9});
    }
  }
  SceneDelta delta;
  delta.upsert_instances = {{.id = "ground", .mesh = testing::MeshOf(uneven)}};
  delta.upsert_lights = {testing::Ceiling()};
  delta.upsert_receivers = {
      {.id = "floor", .shape = PlanarSurface{"ground", 0}, .width = 64, .height = 64}};
  const auto artifact = Compute(*testing::SceneOf(delta), {.samples = 16});
  ASSERT_TRUE(artifact.ok()) << artifact.status();
  for (const uint16_t count : TextureOf(*artifact).visibility.counts) ASSERT_EQ(count, 16);
}

}  // namespace
}  // namespace penumbra
