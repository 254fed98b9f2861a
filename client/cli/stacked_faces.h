// Images of several faces, one below the other.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "render/artifact/light_view.h"

namespace penumbra {

// A face's H×W numbers; none: it has no such plane.
struct StackedFace {
  const LightView& view;
  std::span<const float> numbers;
};

struct StackedImage {
  uint32_t width = 0, height = 0;
  std::vector<float> numbers;
};

// `missing` where no face has a number.
inline StackedImage Stack(std::span<const StackedFace> faces, float missing) {
  StackedImage image;
  for (const StackedFace& face : faces) {
    image.width = std::max(image.width, face.view.width);
    image.height += face.view.height;
  }
  image.numbers.assign(size_t{image.width} * image.height, missing);
  float* row = image.numbers.data();
  for (const StackedFace& face : faces) {
    for (uint32_t y = 0; y < face.view.height; ++y, row += image.width) {
      if (face.numbers.empty()) continue;
      std::copy_n(face.numbers.data() + size_t{y} * face.view.width, face.view.width, row);
    }
  }
  return image;
}

}  // namespace penumbra
