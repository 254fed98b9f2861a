#include "render/artifact/soft_shadow_texture.h"

#include "render/math/parallel_for.h"
#include "render/scene/unoccluded_light.h"

namespace penumbra {

RadianceTexture ReflectedRadiance(const SoftShadowTexture& texture, const std::stop_token& stop) {
  const VisibilityMap& visibility = texture.visibility;
  const ReceiverPatch& receiver = texture.receiver;
  RadianceTexture radiance{visibility.width, visibility.height, {}};
  radiance.texels.resize(visibility.counts.size());
  const Vec3 normal = receiver.patch.normal();
  const auto shade_row = [&](uint32_t j) {
    if (stop.stop_requested()) return;
    for (uint32_t i = 0; i < visibility.width; ++i) {
      const Vec3 point = receiver.TexelCenter(i, j);
      Vec3 unoccluded = UnoccludedRadiance(texture.light, point, normal);
      if (receiver.two_sided) unoccluded += UnoccludedRadiance(texture.light, point, -normal);
      radiance.texels[size_t{j} * visibility.width + i] =
          receiver.reflectance * unoccluded * visibility.Fraction(i, j);
    }
  };
  ParallelFor(visibility.height, shade_row);
  return radiance;
}

}  // namespace penumbra
