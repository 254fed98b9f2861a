#include "render/artifact/artifact.h"

#include <algorithm>
#include <cmath>

namespace penumbra {
namespace {

uint32_t TexelOf(double t, uint32_t count) {
  return static_cast<uint32_t>(std::clamp(std::floor(t * count), 0.0, count - 1.0));
}

struct Texel {
  uint32_t i, j;
};

Texel TexelAt(const SoftShadowTexture& texture, Vec3 point) {
  const DVec2 uv = UvOnPatch(texture.receiver.patch, DVec3(point));
  return {TexelOf(uv.x, texture.visibility.width), TexelOf(uv.y, texture.visibility.height)};
}

float VisibilityAt(const SoftShadowTexture& texture, Vec3 point) {
  const auto [i, j] = TexelAt(texture, point);
  return texture.visibility.Fraction(i, j);
}

bool CoversAt(const SoftShadowTexture& texture, Vec3 point) {
  const auto [i, j] = TexelAt(texture, point);
  return texture.coverage == nullptr || texture.coverage->At(i, j);
}

}  // namespace

float Visibility(const Artifact& artifact, Vec3 point, Vec3 /*normal*/) {
  return std::visit([&](const auto& payload) { return VisibilityAt(payload, point); },
                    artifact.payload);
}

bool Covers(const Artifact& artifact, Vec3 point) {
  return std::visit([&](const auto& payload) { return CoversAt(payload, point); },
                    artifact.payload);
}

}  // namespace penumbra
