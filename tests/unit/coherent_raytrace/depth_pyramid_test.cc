// Pyramids against all of their pixels, and the conservative picture against every triangle.
#include "render/technique/coherent_raytrace/depth_pyramid.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/random_scene.h"

namespace penumbra {
namespace {

DepthMap RandomMap(testing::Dice& dice, uint32_t width, uint32_t height, bool parallel) {
  DepthMap map;
  map.view = {.from_infinity = parallel,
              .window = {DVec2(-1), DVec2(1)},
              .width = width,
              .height = height,
              .near = 1,
              .far = 3};
  for (uint32_t i = 0; i < width * height; ++i) {
    const bool is_near = (i / 3 + i / width / 3) % 3 == 0;
    map.depths.push_back(dice.Below(5) == 0 ? kNoDepth
                                            : (is_near ? 1.2f : 2.0f) + dice.Between(0, 0.12f));
  }
  return map;
}

// In metres, as the header says it.
bool ShowOneSurface(double a, double b, const GapBias& gap, const LightView& view) {
  if (std::isinf(a) || std::isinf(b)) return false;
  const double nearer = std::min(a, b);
  double limit = gap.pixels * PixelWidthAt(view, view.from_infinity ? 1.0 : nearer);
  if (gap.relative && !view.from_infinity) limit = *gap.relative * nearer;
  if (gap.metres) limit = *gap.metres;
  return std::abs(a - b) <= limit;
}

struct Expected {
  DepthPyramid::Node node{std::numeric_limits<float>::infinity(), 0};
  bool joined = true;
};

// Of all pixels of a node and all their neighbours in it.
Expected FromPixels(const DepthPyramid& pyramid, const DepthMap& map, const GapBias& gap, int level,
                    int x, int y) {
  Expected expected;
  const int width = pyramid.width(0), height = pyramid.height(0);
  for (int py = y << level; py < std::min((y + 1) << level, height); ++py) {
    for (int px = x << level; px < std::min((x + 1) << level, width); ++px) {
      const float depth = map.At(px, py);
      const float n = depth == kNoDepth ? 0 : float(pyramid.nearness().Of(depth));
      expected.node = {std::min(expected.node.far, n), std::max(expected.node.near, n)};
      expected.joined &= depth != kNoDepth;
      for (int k = 1; k < 4; ++k) {
        const int qx = px + k % 2, qy = py + k / 2;
        if (qx >> level != x || qy >> level != y || qx >= width || qy >= height) continue;
        expected.joined &= ShowOneSurface(depth, map.At(qx, qy), gap, map.view);
        if (k < 3) continue;
        expected.joined &= ShowOneSurface(map.At(qx, py), map.At(px, qy), gap, map.view);
      }
    }
  }
  return expected;
}

TEST(DepthPyramidTest, NodesAreWhatTheirPixelsAre) {
  testing::Dice dice(1);
  for (int i = 0; i < 40; ++i) {
    const bool parallel = i % 2 == 1;
    const DepthMap map = RandomMap(dice, 1 + dice.Below(20), 1 + dice.Below(20), parallel);
    GapBias gap;
    gap.pixels = 0.7;
    if (i % 3 == 1) gap.metres = 0.07;
    if (i % 3 == 2) gap.relative = 0.05;
    const DepthPyramid pyramid(map, gap, true);
    const int width = pyramid.width(0), height = pyramid.height(0);
    for (int level = 0; level <= pyramid.top(); ++level) {
      for (int y = 0; y < pyramid.height(level); ++y) {
        for (int x = 0; x < pyramid.width(level); ++x) {
          const auto [node, joined] = FromPixels(pyramid, map, gap, level, x, y);
          EXPECT_EQ(pyramid.At(level, x, y).far, node.far);
          EXPECT_EQ(pyramid.At(level, x, y).near, node.near);
          // It may be told less than is so, at the picture's edges.
          const bool is_whole = (x + 1) << level <= width && (y + 1) << level <= height;
          const bool told = pyramid.IsOneSurface(level, x, y);
          if (is_whole && level == 1) {
            EXPECT_EQ(told, joined) << level;
          }
          if (told) {
            EXPECT_TRUE(joined) << level;
          }
        }
      }
    }
  }
}

TEST(DepthPyramidTest, NothingIsJoinedToWhereNothingIs) {
  testing::Dice dice(2);
  const DepthPyramid pyramid(RandomMap(dice, 4, 4, false), {.metres = 1e30}, true);
  EXPECT_FALSE(pyramid.AreJoined(0.0f, 0.5f));
  EXPECT_FALSE(pyramid.AreJoined(0.0f, 0.0f));
  EXPECT_TRUE(pyramid.AreJoined(0.1f, 0.9f));
}

}  // namespace
}  // namespace penumbra
