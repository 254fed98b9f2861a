// A picture in linear light, before it is toned for a screen.
#pragma once

#include <cstddef>
#include <vector>

#include "render/math/vec.h"

namespace penumbra {

// H×W pixels, row 0 at the top. RGB is radiance in W·m⁻²·sr⁻¹, times the share of the pixel that
// something covers, which is A: 0 where only background shows.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<Vec4> pixels;  // H·W

  const Vec4& At(int x, int y) const { return pixels[static_cast<size_t>(y) * width + x]; }
};

}  // namespace penumbra
