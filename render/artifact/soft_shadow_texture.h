// Soft shadows on one patch from one light.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "render/artifact/radiance_format.h"
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

  // What the texels can be told in without further loss.
  RadianceFormat format = RadianceFormat::kFloat32;
  float scale = 1.0f;  // the largest radiance of kUnorm16 and kUnorm8; otherwise 1
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
  // Bits that a count takes where it is sent or written: 8, 16, or 0: 8 if the sample count allows.
  uint32_t count_bits = 0;

  bool has_byte_counts() const {
    return count_bits == 8 || (count_bits == 0 && visibility.sample_count <= 255);
  }
};

// Rounds the texels to `format`. What is above the largest number becomes that.
//
// scale  > 0; of kUnorm16 and kUnorm8 alone
void RoundTo(RadianceFormat format, float scale, RadianceTexture& radiance);

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
