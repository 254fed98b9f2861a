// What a grid of texels knows of a light: how much of it each one sees, and what reaches it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "render/artifact/radiance_format.h"
#include "render/math/vec.h"
#include "render/scene/coverage_mask.h"

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

// H×W radiance, linear RGB in W·m⁻²·sr⁻¹, row 0 at v = 0.
struct RadianceTexture {
  uint32_t width = 0;
  uint32_t height = 0;
  std::vector<Vec3> texels;  // H·W

  // What the texels can be told in without further loss.
  RadianceFormat format = RadianceFormat::kFloat32;
  float scale = 1.0f;  // the largest radiance of kUnorm16 and kUnorm8; otherwise 1
};

struct ShadowTexels {
  VisibilityMap visibility;
  // Only where the spec asked for it.
  std::optional<RadianceTexture> radiance;
  // The texels that are surface; null: all of them.
  std::shared_ptr<const CoverageMask> coverage;
  // Bits that a count takes where it is sent or written: 8, 16, or 0: 8 if the sample count allows.
  uint32_t count_bits = 0;

  bool has_byte_counts() const {
    return count_bits == 8 || (count_bits == 0 && visibility.sample_count <= 255);
  }
};

// A texel as its code holds it.
Vec3 Rounded(const RadianceCodec& codec, Vec3 radiance);

// Rounds the texels to `format`. What is above the largest number becomes that.
//
// scale  > 0; of kUnorm16 and kUnorm8 alone
void RoundTo(RadianceFormat format, float scale, RadianceTexture& radiance);

}  // namespace penumbra
