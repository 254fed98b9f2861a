// Depths in the form in which rays are straight lines on an image.
#pragma once

#include "render/artifact/light_view.h"

namespace penumbra {

// 1/z in 1/m, as seen from infinitely far the distance in m to a plane behind the far one: linear
// along the image of a straight line, and growing towards the eye. What is not there is at 0.
class Nearness {
 public:
  explicit Nearness(const LightView& view)
      : offset_(view.from_infinity ? view.far + 0x1p-8 * (view.far - view.near) + 1e-30 : 0.0),
        from_infinity_(view.from_infinity) {}

  double Of(double depth) const { return from_infinity_ ? offset_ - depth : 1 / depth; }
  double DepthOf(double nearness) const {
    return from_infinity_ ? offset_ - nearness : 1 / nearness;
  }

 private:
  double offset_;
  bool from_infinity_;
};

// How wide a pixel is at `depth`, in m.
inline double PixelWidthAt(const LightView& view, double depth) {
  const DVec2 pixels = view.pixels_per_slope();
  return (view.from_infinity ? 1.0 : depth) / (pixels.x < pixels.y ? pixels.x : pixels.y);
}

}  // namespace penumbra
