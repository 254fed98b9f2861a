// Looking layers up in depth maps, compiled for several instruction sets and chosen when first
// called.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "render/technique/layered_attenuation/view_warp.h"

namespace penumbra {

// The most single-precision lanes that any instruction set here has; arrays are padded by as much.
inline constexpr size_t kLayerLanes = 16;

// Layers as ImagePlanes of the middle view, an array for each property.
struct LayerArrays {
  const float* x;
  const float* y;
  const float* nearness;
  const float* gradient_x;
  const float* gradient_y;
  uint16_t* count;
  size_t size;
};

struct LookupMap {
  ViewWarp warp;
  const float* nearness;  // of what the pixels see; of nothing 0, from infinitely far −∞
  int32_t width;
  int32_t height;
  bool from_infinity;
  // One a pixel, which becomes 1 where a layer is what the pixel sees, and one more, of no meaning;
  // or null.
  uint8_t* explained;
};

// What is the same surface: nearness may differ by pixels · (width · nearness + |gradient|), the
// width without nearness from infinitely far.
struct LayerTolerance {
  float pixels;
  float width;  // of a pixel on the image plane
};

// Adds to the count of each layer how many of the maps have nothing nearer, by more than the
// tolerance, at the pixel where they would see it. What a map's window leaves out is not hidden.
void CountVisible(const LayerArrays& layers, std::span<const LookupMap> maps,
                  const LayerTolerance& tolerance);

}  // namespace penumbra
