// Soft shadows on one patch from one light.
#pragma once

#include <stop_token>

#include "render/artifact/shadow_texels.h"
#include "render/math/vec.h"
#include "render/scene/area_light.h"
#include "render/scene/receiver.h"

namespace penumbra {

// The radiance is reflected: the same as ReflectedRadiance(), but for the method gl. Of the mask,
// texels near the receiver hold what the nearest one inside holds, so that no filter mixes in
// anything foreign; further off, 0.
struct SoftShadowTexture : ShadowTexels {
  ReceiverPatch receiver;  // without its region
  AreaLight light;
};

struct ProductOptions {
  // Bound on the relative error of the unoccluded radiance at each texel (unoccluded_texture.h); 0:
  // closed form at every texel.
  double form_factor_error = 0;
  Vec3 ambient{0.0f};  // radiance that reaches every texel, W·m⁻²·sr⁻¹
};

// Reflected radiance at each texel centre: reflectance · (ambient + unoccluded radiance · visible
// fraction). A two-sided receiver adds what reaches it from either side.
//
// Shapes  H×W counts → H×W×3
// Source  Herf 1997, equation 4.1
//
// Of a light that crosses the receiver's plane both sides get the same visible fraction. Once
// `stop` is requested, blocks that have not begun are left black.
RadianceTexture ReflectedRadiance(const SoftShadowTexture& texture,
                                  const ProductOptions& options = {},
                                  const std::stop_token& stop = {});

}  // namespace penumbra
