// What touches what it shades.
#include <gtest/gtest.h>

#include <utility>

#include "render/technique/shadow_width/shadow_width.h"
#include "tests/unit/shadow_width/small_scenes.h"

namespace penumbra::testing {
namespace {

// What stands on the floor: its far side touches it.
TEST(ShadowContactTest, ContactIsDark) {
  for (const uint32_t layers : {1u, 2u}) {
    SceneDelta delta{
        .upsert_instances = {Ground(), Box("box", {0.8f, 0.5f, 0}, Vec3(0.2f, 0.5f, 0.2f))},
        .upsert_lights = {Lamp(0.4f)}};
    const auto artifact = Compute(delta, {.layers = layers});
    for (float x = 1.01f; x < 1.1f; x += 0.01f) EXPECT_LT(OnFloor(*artifact, x, 0), 0.3f) << x;
  }
}

// Where it touches the floor no ray meets its far side. What is lit of it, under a board and a
// shelf, is as lit as that of something that floats.
TEST(ShadowContactTest, WhatTouchesTheFloorDoesNotShadeItself) {
  const auto top_of = [](float bottom, uint32_t layers) {
    const Vec3 half(0.6f, 0.2f, 0.6f);
    return Compute({.upsert_instances = {Ground(), Box("board", {0, 1.8f, 0}, {0.3f, 0.02f, 0.3f}),
                                         Box("shelf", {0, 1.5f, 0}, {0.3f, 0.02f, 0.3f}),
                                         Box("stand", {0, bottom + half.y, 0}, half)},
                    .upsert_lights = {Lamp(1.0f)}},
                   {.layers = layers});
  };
  for (const uint32_t layers : {1u, 2u}) {
    const auto touching = top_of(0, layers), floating = top_of(0.02f, layers);
    for (float x = 0.3f; x < 0.56f; x += 0.02f) {
      EXPECT_NEAR(OnFloor(*touching, x, 0.1f, 0.4f), OnFloor(*floating, x, 0.1f, 0.42f), 0.05f)
          << layers << " " << x;
    }
    EXPECT_GT(OnFloor(*touching, 0.52f, 0.1f, 0.4f), 0.5f);
  }
}

}  // namespace
}  // namespace penumbra::testing
