// Soft shadows on one patch from one light.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "render/math/vec.h"
#include "render/scene/area_light.h"
#include "render/scene/coverage_mask.h"
#include "render/scene/receiver.h"

namespace penumbra {

// H×W counts of visible light samples, row 0 at v = 0.
struct VisibilityMap {
  uint32_t width = 0;
  uint32_t height = 0;
  uint32_t sample_count = 0;     // n
  std::vector<uint16_t> counts;  // H·W, each in [0, n]

  uint16_t At(uint32_t i, uint32_t j) const { return counts[size_t{j} * width + i]; }
  float Fraction(uint32_t i, uint32_t j) const {
    return sample_count == 0 ? 1.0f : static_cast<float>(At(i, j)) / sample_count;
  }
};

// H×W reflected radiance, linear RGB in W·m⁻²·sr⁻¹, row 0 at v = 0.
struct RadianceTexture {
  uint32_t width = 0;
  uint32_t height = 0;
  std::vector<Vec3> texels;  // H·W
};

struct SoftShadowTexture {
  ReceiverPatch receiver;  // without its region
  AreaLight light;
  VisibilityMap visibility;
  // Only where the spec asked for it. The same as ReflectedRadiance(), but for the method gl.
  std::optional<RadianceTexture> radiance;
  // The texels whose centre lies on the receiver; null: all of them. Near them, the texels outside
  // hold what the nearest one inside holds, so that no filter mixes in anything foreign; further
  // off, 0.
  std::shared_ptr<const CoverageMask> coverage;
};

// Reflected radiance at each texel centre: reflectance · unoccluded radiance · visible fraction. A
// two-sided receiver adds what reaches it from either side.
//
// Shapes  H×W counts → H×W×3
// Source  Herf 1997, equation 4.1; the ambient term is left to whoever draws
//
// Of a light that crosses the receiver's plane both sides get the same visible fraction. Once
// `stop` is requested, rows that have not begun are left black.
RadianceTexture ReflectedRadiance(const SoftShadowTexture& texture,
                                  const std::stop_token& stop = {});

}  // namespace penumbra
