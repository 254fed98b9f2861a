// The depth of what a view sees first.
#pragma once

#include <limits>
#include <vector>

#include "render/artifact/light_view.h"

namespace penumbra {

inline constexpr float kNoDepth = std::numeric_limits<float>::infinity();

// H×W depths, in metres as LightView measures them, row 0 at the window's smallest y; kNoDepth
// where nothing is seen.
struct DepthMap {
  LightView view;
  std::vector<float> depths;

  float At(uint32_t x, uint32_t y) const { return depths[size_t{y} * view.width + x]; }
};

}  // namespace penumbra
