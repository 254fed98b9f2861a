#include "client/cli/bake_files.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "client/cli/output_files.h"
#include "client/display/image_io.h"
#include "client/display/tone.h"

namespace penumbra {
namespace {

// The channels of the EXR file, each with its own memory.
struct BakePlanes {
  std::vector<float> red, green, blue, count, inside;
};

BakePlanes PlanesOf(const RadianceTexture& radiance, const SoftShadowTexture& texture) {
  const VisibilityMap& map = texture.visibility;
  BakePlanes planes;
  for (const Vec3 texel : radiance.texels) {
    planes.red.push_back(texel.x);
    planes.green.push_back(texel.y);
    planes.blue.push_back(texel.z);
  }
  planes.count.assign(map.counts.begin(), map.counts.end());
  planes.inside.assign(map.counts.size(), 1.0f);
  for (size_t k = 0; texture.coverage && k < planes.inside.size(); ++k) {
    if (!texture.coverage->At(k)) planes.inside[k] = 0.0f;
  }
  return planes;
}

float BrightestChannel(const RadianceTexture& radiance) {
  float brightest = 0.0f;
  for (const Vec3 texel : radiance.texels) {
    brightest = std::max({brightest, texel.x, texel.y, texel.z});
  }
  return brightest;
}

std::vector<uint8_t> ToSrgb(const RadianceTexture& radiance, float exposure) {
  std::vector<uint8_t> pixels;
  pixels.reserve(radiance.texels.size() * 3);
  for (const Vec3 texel : radiance.texels) {
    for (int channel = 0; channel < 3; ++channel) {
      const float encoded = SrgbFromLinear(exposure * texel[channel]);
      pixels.push_back(static_cast<uint8_t>(std::lround(255.0f * encoded)));
    }
  }
  return pixels;
}

}  // namespace

absl::StatusOr<std::vector<std::string>> WriteBake(const BakeRecord& record,
                                                   const std::filesystem::path& folder) {
  const auto& texture = std::get<SoftShadowTexture>(record.artifact.payload);
  const RadianceTexture radiance =
      texture.radiance ? *texture.radiance : ReflectedRadiance(texture);
  const float brightest = BrightestChannel(radiance);
  const float exposure = record.exposure.value_or(brightest > 0.0f ? 1.0f / brightest : 1.0f);
  const int width = static_cast<int>(texture.visibility.width);
  const int height = static_cast<int>(texture.visibility.height);
  const BakePlanes planes = PlanesOf(radiance, texture);

  std::vector<std::string> files;
  for (const char* extension : {".exr", ".png", ".json"}) files.push_back(record.name + extension);
  const auto path = [&](size_t i) { return folder / files[i]; };
  const bool half = radiance.format == RadianceFormat::kHalf;
  const NamedPlane channels[] = {{"R", planes.red, half},
                                 {"G", planes.green, half},
                                 {"B", planes.blue, half},
                                 {"count", planes.count},
                                 {"inside", planes.inside}};
  absl::Status status = WriteExr(path(0), width, height, channels);
  if (status.ok()) status = WritePng(path(1), width, height, ToSrgb(radiance, exposure));
  if (status.ok()) status = WriteText(path(2), BakeJson(record, texture, exposure));
  if (!status.ok()) return status;
  return files;
}

}  // namespace penumbra
