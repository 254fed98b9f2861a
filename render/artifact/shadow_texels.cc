#include "render/artifact/shadow_texels.h"

namespace penumbra {

Vec3 Rounded(const RadianceCodec& codec, Vec3 radiance) {
  for (int c = 0; c < 3; ++c) radiance[c] = codec.Decode(codec.Encode(radiance[c]));
  return radiance;
}

void RoundTo(RadianceFormat format, float scale, RadianceTexture& radiance) {
  radiance.format = format;
  radiance.scale = IsUnorm(format) ? scale : 1.0f;
  if (format == RadianceFormat::kFloat32) return;
  const RadianceCodec codec(format, radiance.scale);
  for (Vec3& texel : radiance.texels) texel = Rounded(codec, texel);
}

}  // namespace penumbra
