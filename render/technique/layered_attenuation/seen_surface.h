// What a depth map's pixel says of a surface.
#pragma once

#include <cstdint>
#include <vector>

#include "render/artifact/depth_map.h"
#include "render/technique/layered_attenuation/view_warp.h"

namespace penumbra {

// A depth map with nearness in place of depth: 0, from infinitely far −∞, where nothing is seen.
struct NearnessMap {
  explicit NearnessMap(DepthMap map);

  const float* Row(uint32_t y) const { return &nearness[size_t{y} * view.width]; }
  float nothing() const { return NearnessOf(view.from_infinity, kNoDepth); }

  LightView view;
  std::vector<float> nearness;
};

// The slope of nearness at pixel (x, y): in each direction to the neighbour that is more alike.
Vec2 GradientAt(const NearnessMap& map, uint32_t x, uint32_t y);

// The plane with its gradient cut to kMaxSteepness pixels' widths a pixel.
//
// pixel_width  on the image plane
ImagePlane WithoutCliffs(ImagePlane plane, float pixel_width, bool from_infinity);

}  // namespace penumbra
