#include "render/technique/soft_texture/texture_shading.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <variant>

#include "render/artifact/unoccluded_texture.h"
#include "render/math/parallel_for.h"
#include "render/scene/unoccluded_light.h"

namespace penumbra {
namespace {

bool IsSphere(const AreaLight& light) { return std::holds_alternative<SphereLight>(light.shape); }

RadianceTexture BlackTexture(const SoftShadowTexture& texture) {
  const VisibilityMap& map = texture.visibility;
  return {map.width, map.height, std::vector<Vec3>(map.counts.size(), Vec3(0.0f))};
}

float LargestOf(Vec3 rgb) { return std::max({rgb.x, rgb.y, rgb.z}); }

float LargestFactor(const SoftShadowTexture& texture, double form_factor_error,
                    const std::stop_token& stop) {
  std::mutex mutex;
  float largest = 0;
  const UnoccludedTexture factors(texture.light, texture.receiver, form_factor_error);
  factors.ForEachBlock(stop, [&](const TexelBlock&, std::span<const float> values) {
    const float most = *std::max_element(values.begin(), values.end());
    const std::lock_guard lock(mutex);
    largest = std::max(largest, most);
  });
  return largest;
}

}  // namespace

float LargestUnoccluded(const SoftShadowTexture& texture, double form_factor_error,
                        const std::stop_token& stop) {
  return LargestOf(texture.receiver.reflectance * LightStrength(texture.light)) *
         LargestFactor(texture, form_factor_error, stop);
}

TextureShading::TextureShading(const AreaLight& light, const ReceiverPatch& receiver,
                               double surface_offset, uint32_t total,
                               const SoftTextureParams& params)
    : options_{.form_factor_error = params.form_factor_error, .ambient = params.ambient},
      format_(params.output),
      given_scale_(params.output_scale) {
  if (params.radiance && params.shading == Shading::kSampleSum && HasUnequalSamples(light)) {
    const bool finds_scale = IsUnorm(format_) && given_scale_ == 0;
    sum_.emplace(light, receiver, surface_offset, total, IsSphere(light) || finds_scale);
  }
}

RadianceTexture TextureShading::Shade(const SoftShadowTexture& texture,
                                      const std::stop_token& stop) const {
  RadianceTexture radiance = Exact(texture, stop);
  Round(texture, stop, radiance);
  return radiance;
}

RadianceTexture TextureShading::Finish(RadianceTexture exact, const SoftShadowTexture& texture,
                                       const std::stop_token& stop) const {
  const Vec3 ambient = texture.receiver.reflectance * options_.ambient;
  for (Vec3& texel : exact.texels) texel += ambient;
  Round(texture, stop, exact);
  return exact;
}

void TextureShading::Round(const SoftShadowTexture& texture, const std::stop_token& stop,
                           RadianceTexture& radiance) const {
  const bool finds_scale = IsUnorm(format_) && given_scale_ == 0;
  RoundTo(format_, finds_scale ? ScaleFor(texture, stop) : given_scale_, radiance);
}

float TextureShading::ScaleFor(const SoftShadowTexture& texture,
                               const std::stop_token& stop) const {
  const Vec3 reflectance = texture.receiver.reflectance;
  float largest = 0;
  if (sum_ && !IsSphere(texture.light)) {
    for (uint32_t row = 0; row < texture.visibility.height; ++row) {
      for (const float all : sum_->All(row)) largest = std::max(largest, all);
    }
    largest /= static_cast<float>(texture.visibility.sample_count);
  } else {
    largest = LargestFactor(texture, options_.form_factor_error, stop);
  }
  const Vec3 strength = LightStrength(texture.light);
  const float scale = LargestOf(reflectance * (options_.ambient + strength * largest));
  return scale > 0 && std::isfinite(scale) ? scale : 1;
}

RadianceTexture TextureShading::Exact(const SoftShadowTexture& texture,
                                      const std::stop_token& stop) const {
  if (!sum_) return ReflectedRadiance(texture, options_, stop);
  return IsSphere(texture.light) ? ShadeInProportion(texture, stop) : ShadeBySum(texture, stop);
}

RadianceTexture TextureShading::ShadeBySum(const SoftShadowTexture& texture,
                                           const std::stop_token& stop) const {
  RadianceTexture radiance = BlackTexture(texture);
  const Vec3 reflectance = texture.receiver.reflectance;
  const Vec3 per_sample =
      LightStrength(texture.light) / static_cast<float>(texture.visibility.sample_count);
  ParallelFor(radiance.height, [&](uint32_t row) {
    if (stop.stop_requested()) return;
    const std::span<const float> visible = sum_->Visible(row);
    Vec3* const texels = &radiance.texels[size_t{row} * radiance.width];
    for (uint32_t i = 0; i < radiance.width; ++i) {
      texels[i] = reflectance * (options_.ambient + per_sample * visible[i]);
    }
  });
  return radiance;
}

RadianceTexture TextureShading::ShadeInProportion(const SoftShadowTexture& texture,
                                                  const std::stop_token& stop) const {
  RadianceTexture radiance = BlackTexture(texture);
  const VisibilityMap& map = texture.visibility;
  const Vec3 reflectance = texture.receiver.reflectance;
  const Vec3 strength = LightStrength(texture.light);
  const UnoccludedTexture factors(texture.light, texture.receiver, options_.form_factor_error);
  factors.ForEachBlock(stop, [&](const TexelBlock& block, std::span<const float> values) {
    for (uint32_t j = 0; j < block.height; ++j) {
      const uint32_t row = block.y + j;
      const std::span<const float> visible = sum_->Visible(row), all = sum_->All(row);
      for (uint32_t i = block.x; i < block.x + block.width; ++i) {
        // Inside the sphere, or behind all of its samples, they count alike.
        const float share = all[i] > 0 ? visible[i] / all[i] : map.Fraction(i, row);
        const float factor = values[size_t{j} * block.width + i - block.x] * share;
        radiance.texels[size_t{row} * map.width + i] =
            reflectance * (options_.ambient + strength * factor);
      }
    }
  });
  return radiance;
}

}  // namespace penumbra
