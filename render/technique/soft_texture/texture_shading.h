// Radiance textures from counts, by either of the paper's two formulas.
//
//   TextureShading shading(light, receiver, surface_offset, samples.size(), params);
//   if (shading.sum()) counter.SumInto(*shading.sum());
//   texture.radiance = shading.Shade(texture, stop);
#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>

#include "render/artifact/soft_shadow_texture.h"
#include "render/technique/soft_texture/sample_sum.h"
#include "render/technique/soft_texture/soft_texture_params.h"

namespace penumbra {

// The largest radiance, of any channel, that one light can give any texel of `texture`.
float LargestUnoccluded(const SoftShadowTexture& texture, double form_factor_error,
                        const std::stop_token& stop = {});

class TextureShading {
 public:
  // total  light samples in all
  TextureShading(const AreaLight& light, const ReceiverPatch& receiver, double surface_offset,
                 uint32_t total, const SoftTextureParams& params);

  // Where samples are to be added up; null: counts are all that is needed.
  SampleSum* sum() { return sum_ ? &*sum_ : nullptr; }

  // Radiance from the samples counted so far.
  //
  //   product     L = ρ (L_a + L_light F · visible fraction)
  //   sample_sum  L = ρ (L_a + L_light / n Σ_i a_i cos θ_i cos θ'_i / (π r_i²) v_i)
  //
  // A sphere's samples lie on the half that faces the middle of the patch. From elsewhere some of
  // them are beyond its edge, and a part of what is seen holds none. So its sum is taken in
  // proportion to the sum over all samples, and times the closed form: what nothing hides is exact.
  //
  // The texels are rounded to the format asked for. Where no scale of it is given, it is the
  // largest radiance that the texture would have with nothing in the way, so that occluders may
  // move without changing it.
  //
  // Errors  texels not begun when `stop` is requested are black
  // Source  Herf 1997, equations 3.2 and 4.1
  RadianceTexture Shade(const SoftShadowTexture& texture, const std::stop_token& stop) const;

  // The same of `exact`, which lacks the ambient term and is not rounded yet.
  RadianceTexture Finish(RadianceTexture exact, const SoftShadowTexture& texture,
                         const std::stop_token& stop) const;

 private:
  void Round(const SoftShadowTexture& texture, const std::stop_token& stop,
             RadianceTexture& radiance) const;

  RadianceTexture Exact(const SoftShadowTexture& texture, const std::stop_token& stop) const;
  RadianceTexture ShadeBySum(const SoftShadowTexture& texture, const std::stop_token& stop) const;
  RadianceTexture ShadeInProportion(const SoftShadowTexture& texture,
                                    const std::stop_token& stop) const;

  float ScaleFor(const SoftShadowTexture& texture, const std::stop_token& stop) const;

  const ProductOptions options_;
  const RadianceFormat format_;
  const float given_scale_;
  std::optional<SampleSum> sum_;
};

}  // namespace penumbra
