#include "render/artifact/shadow_texels.h"

namespace penumbra {

void RoundTo(RadianceFormat format, float scale, RadianceTexture& radiance) {
  radiance.format = format;
  radiance.scale = IsUnorm(format) ? scale : 1.0f;
  if (format == RadianceFormat::kFloat32) return;
  const RadianceCodec codec(format, radiance.scale);
  for (Vec3& texel : radiance.texels) {
    for (int c = 0; c < 3; ++c) texel[c] = codec.Decode(codec.Encode(texel[c]));
  }
}

}  // namespace penumbra
