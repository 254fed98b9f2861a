#include "render/scene/coverage_mask.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace penumbra {
namespace {

TEST(CoverageMask, TheGutterRepeatsTheNearestTexelInside) {
  std::mt19937 random(8);
  CoverageMask mask(61, 43);
  for (int k = 0; k < 25; ++k) mask.Set(random() % mask.texel_count());
  constexpr int kReach = 9;
  std::vector<uint32_t> stands_for(mask.texel_count(), ~0u);
  for (const GutterTexel& texel : FindGutter(mask, kReach)) {
    stands_for[texel.outside] = texel.inside;
    ASSERT_FALSE(mask.At(texel.outside));
    ASSERT_TRUE(mask.At(texel.inside));
  }
  const auto distance = [](uint32_t a, uint32_t b) {
    return std::hypot(double(a % 61) - double(b % 61), double(a / 61) - double(b / 61));
  };
  for (uint32_t k = 0; k < mask.texel_count(); ++k) {
    double nearest = 1e9;
    for (uint32_t other = 0; other < mask.texel_count(); ++other) {
      if (mask.At(other)) nearest = std::min(nearest, distance(k, other));
    }
    if (nearest == 0) {
      EXPECT_EQ(stands_for[k], ~0u);
    } else if (nearest < kReach - 0.1) {
      ASSERT_NE(stands_for[k], ~0u);
      EXPECT_LE(distance(k, stands_for[k]), nearest + 0.1);
    } else if (nearest > kReach) {
      EXPECT_EQ(stands_for[k], ~0u);
    }
  }
}

TEST(CoverageMask, BitsRunRowByRowFromTheLowestOn) {
  CoverageMask mask(5, 3);
  mask.Set(0);
  mask.Set(9);
  EXPECT_EQ(mask.bytes()[0], 1);
  EXPECT_EQ(mask.bytes()[1], 2);
  EXPECT_TRUE(mask.At(4, 1));
  EXPECT_EQ(mask.CountInside(), 2u);
}

}  // namespace
}  // namespace penumbra
