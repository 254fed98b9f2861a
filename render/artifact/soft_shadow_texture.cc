#include "render/artifact/soft_shadow_texture.h"

#include "render/scene/unoccluded_light.h"
#include "tbb/blocked_range.h"
#include "tbb/parallel_for.h"

namespace penumbra {

RadianceTexture ReflectedRadiance(const SoftShadowTexture& texture) {
  const VisibilityMap& visibility = texture.visibility;
  const ReceiverPatch& receiver = texture.receiver;
  RadianceTexture radiance{visibility.width, visibility.height, {}};
  radiance.texels.resize(visibility.counts.size());
  const Vec3 normal = receiver.patch.normal();
  const auto shade_row = [&](uint32_t j) {
    for (uint32_t i = 0; i < visibility.width; ++i) {
      const Vec3 point = receiver.TexelCenter(i, j);
      Vec3 unoccluded = UnoccludedRadiance(texture.light, point, normal);
      if (receiver.two_sided) unoccluded += UnoccludedRadiance(texture.light, point, -normal);
      radiance.texels[size_t{j} * visibility.width + i] =
          receiver.reflectance * unoccluded * visibility.Fraction(i, j);
    }
  };
  tbb::parallel_for(tbb::blocked_range<uint32_t>(0, visibility.height),
                    [&](const tbb::blocked_range<uint32_t>& rows) {
                      for (uint32_t j = rows.begin(); j < rows.end(); ++j) shade_row(j);
                    });
  return radiance;
}

}  // namespace penumbra
