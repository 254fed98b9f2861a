#include "render/artifact/soft_shadow_texture.h"

#include "render/artifact/unoccluded_texture.h"
#include "render/scene/unoccluded_light.h"

namespace penumbra {

RadianceTexture ReflectedRadiance(const SoftShadowTexture& texture, const ProductOptions& options,
                                  const std::stop_token& stop) {
  const VisibilityMap& visibility = texture.visibility;
  const ReceiverPatch& receiver = texture.receiver;
  RadianceTexture radiance{visibility.width, visibility.height, {}};
  radiance.texels.resize(visibility.counts.size());
  const Vec3 strength = LightStrength(texture.light);
  const UnoccludedTexture factors(texture.light, receiver, options.form_factor_error);
  factors.ForEachBlock(stop, [&](const TexelBlock& block, std::span<const float> values) {
    for (uint32_t j = 0; j < block.height; ++j) {
      for (uint32_t i = 0; i < block.width; ++i) {
        const float factor =
            values[size_t{j} * block.width + i] * visibility.Fraction(block.x + i, block.y + j);
        radiance.texels[size_t{block.y + j} * visibility.width + block.x + i] =
            receiver.reflectance * (options.ambient + strength * factor);
      }
    }
  });
  return radiance;
}

}  // namespace penumbra
