#include "render/technique/soft_texture/gl/gl_shadows.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "render/technique/soft_texture/gl/shadow_renderer.h"

namespace penumbra {

absl::Status GlShadows::Add(std::span<const LightSample> samples, const std::stop_token& stop) {
  auto renderer = texture_gl::ShadowRenderer::Of(context_);
  if (!renderer.ok()) return renderer.status();
  const texture_gl::ShadowRequest request{.scene = scene_,
                                          .receiver = receiver_,
                                          .surface_offset = surface_offset_,
                                          .samples = samples,
                                          .light = light_};
  auto drawn = (*renderer)->Draw(context_, std::span(&request, 1), stop);
  if (!drawn.ok()) return drawn.status();
  const texture_gl::ShadowSums& sums = drawn->front();
  std::transform(counts_.begin(), counts_.end(), sums.hidden.begin(), counts_.begin(),
                 std::plus<uint16_t>());
  if (sums_.empty()) {
    sums_ = std::move(drawn->front().radiance);
  } else {
    std::transform(sums_.begin(), sums_.end(), sums.radiance.begin(), sums_.begin(),
                   std::plus<Vec3>());
  }
  sample_count_ += samples.size();
  return absl::OkStatus();
}

RadianceTexture GlShadows::Radiance() const {
  RadianceTexture radiance{receiver_.width, receiver_.height, sums_};
  for (Vec3& texel : radiance.texels) texel /= static_cast<float>(sample_count_);
  return radiance;
}

}  // namespace penumbra
