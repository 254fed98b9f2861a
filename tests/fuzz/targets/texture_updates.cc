// Soft shadow textures and pictures, with radiance and masks, that a server sends to a client.

#include <cstddef>
#include <memory>

#include "tests/fuzz/targets/artifact_updates.h"

namespace penumbra::fuzzing {
namespace {

void FillTexels(ShadowTexels& texels, uint32_t width, uint32_t height, uint32_t samples,
                uint32_t seed) {
  texels.visibility = {.width = width,
                       .height = height,
                       .sample_count = samples,
                       .counts = std::vector<uint16_t>(size_t{width} * height)};
  for (size_t i = 0; i < texels.visibility.counts.size(); ++i) {
    texels.visibility.counts[i] = static_cast<uint16_t>((i * i + seed) % (samples + 1));
  }
}

void AddRadiance(ShadowTexels& texels, RadianceFormat format, float scale) {
  RadianceTexture radiance{
      .width = texels.visibility.width, .height = texels.visibility.height, .texels = {}};
  for (const uint16_t count : texels.visibility.counts) {
    radiance.texels.emplace_back(0.01f * count, 0.25f, count % 3);
  }
  RoundTo(format, scale, radiance);
  texels.radiance = std::move(radiance);
}

void AddMask(ShadowTexels& texels) {
  CoverageMask mask(texels.visibility.width, texels.visibility.height);
  for (size_t i = 0; i < mask.texel_count(); i += 3) mask.Set(i);
  texels.coverage = std::make_shared<const CoverageMask>(mask);
}

Artifact With(ArtifactPayload payload, uint32_t samples) {
  return {.header = {.scene_id = "studio",
                     .revision = 3,
                     .scene_hash = {},
                     .technique = "soft_texture",
                     .light_id = "lamp",
                     .receiver_id = "floor",
                     .parameters = {{"samples", "16"}},
                     .light_samples = {{{1, 2, 3}, false, 0.5f}, {{0, 1, 0}, true, 0.5f}},
                     .samples_requested = samples,
                     .pass = 1,
                     .is_final = true,
                     .timings_ms = {{"compute", 1.5}}},
          .payload = std::move(payload)};
}

Artifact Texture(uint32_t samples, uint32_t seed) {
  SoftShadowTexture texture;
  texture.receiver = {.patch = {}, .width = 70, .height = 66};
  texture.light = {"lamp", DiskLight{.center = {0, 3, 0}, .radius = 0.25f}};
  FillTexels(texture, 70, 66, samples, seed);
  return With(std::move(texture), samples);
}

Artifact MaskedTexture(RadianceFormat format, uint32_t seed) {
  SoftShadowTexture texture;
  texture.receiver = {.patch = {}, .width = 9, .height = 7};
  texture.light = {"lamp", RectangleLight{}};
  FillTexels(texture, 9, 7, 16, seed);
  AddRadiance(texture, format, IsUnorm(format) ? 2.0f : 1.0f);
  AddMask(texture);
  return With(std::move(texture), 16);
}

Artifact Picture(PointReceiver points, uint32_t width, uint32_t height, uint32_t seed) {
  ViewShadow shadow;
  shadow.points = std::move(points);
  shadow.light = {"lamp", SphereLight{.center = {0, 3, 0}}};
  FillTexels(shadow, width, height, 300, seed);
  AddRadiance(shadow, RadianceFormat::kHalf, 1.0f);
  AddMask(shadow);
  shadow.progress = {.fraction_done = 0.5, .rays_traced = 99, .time_left_ms = 20};
  return With(std::move(shadow), 300);
}

Artifact Points(uint32_t seed) {
  const std::vector<SurfacePoint> points = {{{1, 2, 3}, {0, 1, 0}}, {{0, 0, 1}, {1, 0, 0}}};
  return Picture(GivenPoints{std::make_shared<const std::vector<SurfacePoint>>(points)}, 2, 1,
                 seed);
}

class TextureUpdates final : public ArtifactUpdates {
 public:
  std::vector<Seed> Seeds() override {
    const PicturePixels pixels{.camera = {}, .width = 40, .height = 30, .crop = {4, 5, 20, 10}};
    std::vector<Seed> seeds = SeedsOf("texture", Texture(16, 0), Texture(64, 5));
    for (auto more :
         {SeedsOf("float", MaskedTexture(RadianceFormat::kFloat32, 0),
                  MaskedTexture(RadianceFormat::kFloat32, 3)),
          SeedsOf("unorm8", MaskedTexture(RadianceFormat::kUnorm8, 0),
                  MaskedTexture(RadianceFormat::kUnorm16, 0)),
          SeedsOf("picture", Picture(pixels, 20, 10, 0), Picture(pixels, 20, 10, 9)),
          SeedsOf("points", Points(0), Picture(LightmapTexels{"box", 8, 4}, 8, 4, 1))}) {
      seeds.insert(seeds.end(), more.begin(), more.end());
    }
    return seeds;
  }
};

}  // namespace

Target& TheTarget() {
  static TextureUpdates target;
  return target;
}

}  // namespace penumbra::fuzzing
