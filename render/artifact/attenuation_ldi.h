// Layered attenuation maps: all that some point of a light sees, and how much of the light sees it.
//
//   float visible = Visibility(ldi, point, normal);   // from any viewpoint, on any surface
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/artifact/light_view.h"
#include "render/math/vec.h"
#include "render/scene/area_light.h"

namespace penumbra {

// A layered depth image of W×H pixels as seen from the middle of a light: layers
// offsets[p] … offsets[p + 1] are those of pixel p = y·W + x, nearest first.
struct LdiFace {
  LightView view;                 // its eye is the frame's origin
  std::vector<uint32_t> offsets;  // W·H + 1
  std::vector<float> depths;      // in m, as `view` measures them: at the pixel's centre
  std::vector<uint16_t> counts;   // of light samples that see the layer, 0 … sample_count

  size_t layer_count() const { return depths.size(); }
};

struct AttenuationLdi {
  AreaLight light;
  std::vector<LdiFace> faces;  // the first that has a point in its window tells of it
  uint32_t sample_count = 0;   // that the counts are out of, ≥ 1
  // How far from a layer a point may be and still lie on it, in pixels' widths: a layer a pixel
  // away is met from half a pixel further off by rounding, so that 1 is what sampling allows for.
  float tolerance = 1.0f;
};

// The fraction of the light that sees a surface at `point` from the side of `normal`, in [0, 1].
//
// The point's plane on a face's image (plane_on_image.h) says how near the surface is at pixels
// around the point. At each of the four next to it, it is the layer nearest to that which
// counts, if one is within tolerance · spread of it. Where there is none, but one nearer
// than that, no sample has seen the surface there: 0. Where there is nothing nearer the surface's
// edge is passed, and the pixel has no say; the rest is bilinear. Where no pixel has a say, and
// outside of all windows, there is nothing that could hide the point: 1.
//
// No more is returned than LightAbovePlane() is: behind a light that shines from its front alone 0.
//
// normal  of length 1
// Cost    about 0.3 µs
// Source  Agrawala et al. 2000, §4; departs: by planes instead of one depth for all neighbours
float Visibility(const AttenuationLdi& ldi, Vec3 point, Vec3 normal);

}  // namespace penumbra
