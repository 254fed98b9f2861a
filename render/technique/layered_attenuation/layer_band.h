// Layers of some rows of a layered depth image while it is built.
#pragma once

#include <cstdint>
#include <vector>

#include "render/artifact/attenuation_ldi.h"
#include "render/technique/layered_attenuation/count_kernel.h"

namespace penumbra {

// A surface at the centre of one of the middle view's pixels.
struct PixelSurface {
  uint32_t column, row;
  ImagePlane plane;
};

// One thread at a time changes a band; layers are never taken out.
class LayerBand {
 public:
  static constexpr size_t kBytesPerLayer = 5 * sizeof(float) + sizeof(uint16_t) + sizeof(uint32_t);

  // Pixels [0, width) × [first_row, first_row + rows).
  LayerBand(uint32_t width, uint32_t first_row, uint32_t rows);

  uint32_t first_row() const { return first_row_; }
  uint32_t end_row() const { return first_row_ + rows_; }
  size_t size() const { return size_; }
  size_t bytes() const;

  enum class Found { kKnown, kNew, kTooMany };
  // Adds a layer with the count 0 unless the pixel has one within the surface's own tolerance, or
  // has `most` others. The tolerances of layers do not count: a steep one may reach a flat surface
  // behind, whose points would then look for a layer where there is none.
  Found Add(const PixelSurface& surface, const LayerTolerance& tolerance, bool from_infinity,
            uint32_t most);

  // For CountVisible, of those from the `first` on.
  LayerArrays LayersFrom(size_t first);
  ImagePlane Plane(size_t layer) const {
    return {.at = Vec2(x_[layer], y_[layer]),
            .nearness = nearness_[layer],
            .gradient = Vec2(gradient_x_[layer], gradient_y_[layer])};
  }

  // Appends the layers of the band's pixels, nearest first: to `offsets` how many there are before
  // each pixel's. `unhidden` is added to each count.
  void Append(bool from_infinity, uint16_t unhidden, LdiFace& face) const;

 private:
  static constexpr uint32_t kNone = 0xffff'ffff;

  void Grow();

  const uint32_t width_, first_row_, rows_;
  std::vector<uint32_t> heads_;  // one a pixel: its first layer, or kNone
  size_t size_ = 0;
  std::vector<float> x_, y_, nearness_, gradient_x_, gradient_y_;
  std::vector<uint16_t> counts_;
  std::vector<uint32_t> nexts_;  // the pixel's next layer, or kNone
};

}  // namespace penumbra
