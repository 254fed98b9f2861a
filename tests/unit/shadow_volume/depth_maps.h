// Depth maps for tests of shadow volumes.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>

#include "render/artifact/volume_grid.h"
#include "tests/support/random_scene.h"

namespace penumbra::testing {

// 40 degrees wide, from somewhere, in some direction; from infinitely far aslant.
inline LightView SomeView(uint32_t width, uint32_t height, bool from_infinity) {
  LightView view{.frame = {.origin = DVec3(0.3, 5, -0.7), .axes = BasisAround(DVec3(0.2, -1, 0.4))},
                 .from_infinity = from_infinity,
                 .window = {.min = DVec2(-0.31, -0.42), .max = DVec2(0.43, 0.37)},
                 .width = width,
                 .height = height,
                 .near = 1,
                 .far = 9};
  if (from_infinity) view.eye = DVec3(0.1, -0.2, 0);
  return view;
}

inline DepthMap MapOf(const LightView& view,
                      const std::function<float(uint32_t x, uint32_t y)>& depth) {
  DepthMap map{.view = view, .depths = {}};
  for (uint32_t y = 0; y < view.height; ++y) {
    for (uint32_t x = 0; x < view.width; ++x) map.depths.push_back(depth(x, y));
  }
  return map;
}

// Depths in [1, 9], a part of them nothing.
inline DepthMap RandomMap(Dice& dice, const LightView& view, float nothing_share = 0.2f) {
  return MapOf(view, [&](uint32_t, uint32_t) {
    return dice.Between(0, 1) < nothing_share ? kNoDepth : dice.Between(1, 9);
  });
}

// A slope of `steep` pixels' widths a pixel along x, and a square `gap` pixels' widths above it, in
// the middle half, so that its sides lie between samples side/4 − 1 and side/4, and so on.
inline DepthMap SquareOverSlope(uint32_t side, double steep, double gap) {
  const LightView view = SomeView(side, side, false);
  const double pixel = 1 / std::sqrt(view.pixels_per_slope().x * view.pixels_per_slope().y);
  return MapOf(view, [=](uint32_t x, uint32_t y) {
    const bool is_square = x >= side / 4 && x < 3 * side / 4 && y >= side / 4 && y < 3 * side / 4;
    const double nearness =
        0.25 * (1 + steep * pixel * (x - 0.5 * side)) * (1 + is_square * gap * pixel);
    return static_cast<float>(1 / nearness);
  });
}

}  // namespace penumbra::testing
