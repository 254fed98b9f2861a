// Depth maps of many points of a light from those of a few.
//
//   … builder.AddSurfaces(map, arena, stop) … for the middle and for each of KeySamples() …
//   DepthMap map = KeyViews(builder).MapFor(view);   // in place of drawing the scene
#pragma once

#include <vector>

#include "render/artifact/depth_map.h"
#include "render/light_view/light_face.h"
#include "render/scene/light_sample.h"
#include "render/technique/layered_attenuation/ldi_builder.h"

namespace penumbra {

// Four points at the rim of `light`: a rectangle's corners, the ends of two diameters of a disk, of
// a distant light's disc, of the disc that `face` sees of a sphere. None of a light without a size.
std::vector<LightSample> KeySamples(const AreaLight& light, const LightFace& face);

// What key views see, as layers of the middle view, drawn into others: each layer as one pixel, the
// nearest wins. Between two pixels that show neighbours of one surface, which has been stretched,
// the gap is closed. What no key view sees is not there: it is in no layer either, but it hides
// nothing.
//
// Source  Agrawala et al. 2000, §4, discussion
class KeyViews {
 public:
  // Refers to `layers`, which are those to draw.
  explicit KeyViews(const LdiBuilder& layers) : layers_(layers) {}

  // Cost  about 10 ns a layer and 3 ns a pixel
  DepthMap MapFor(const LightView& view) const;

 private:
  const LdiBuilder& layers_;
};

}  // namespace penumbra
