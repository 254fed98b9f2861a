#include "render/artifact/artifact.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <type_traits>
#include <utility>

#include "render/scene/camera.h"

namespace penumbra {
namespace {

// The nearest there is; the first where t is not a number.
uint32_t TexelOf(double t, uint32_t count) {
  const double texel = std::floor(t * count);
  return texel > 0 ? static_cast<uint32_t>(std::min(texel, count - 1.0)) : 0;
}

struct Texel {
  uint32_t i, j;
};

Texel TexelAt(const SoftShadowTexture& texture, Vec3 point) {
  const DVec2 uv = UvOnPatch(texture.receiver.patch, DVec3(point));
  return {TexelOf(uv.x, texture.visibility.width), TexelOf(uv.y, texture.visibility.height)};
}

// nullopt: not in a picture, or behind the camera.
std::optional<Texel> TexelAt(const ViewShadow& shadow, Vec3 point) {
  const auto* picture = std::get_if<PicturePixels>(&shadow.points);
  if (picture == nullptr) return std::nullopt;
  const DVec4 clip = ClipFromWorld(picture->camera, picture->aspect()) * DVec4(DVec3(point), 1);
  if (!(clip.w > 0)) return std::nullopt;
  const DVec2 pixel(0.5 * (clip.x / clip.w + 1) * picture->width,
                    0.5 * (1 - clip.y / clip.w) * picture->height);
  const PixelRect part = picture->part();
  return Texel{TexelOf((pixel.x - part.x) / part.width, shadow.visibility.width),
               TexelOf((pixel.y - part.y) / part.height, shadow.visibility.height)};
}

float VisibilityAt(const SoftShadowTexture& texture, Vec3 point, Vec3 /*normal*/) {
  const auto [i, j] = TexelAt(texture, point);
  return texture.visibility.Fraction(i, j);
}

float VisibilityAt(const AttenuationLdi& ldi, Vec3 point, Vec3 normal) {
  return Visibility(ldi, point, normal);
}

float VisibilityAt(const ShadowWidthMap& map, Vec3 point, Vec3 normal) {
  return Visibility(map, point, normal);
}

float VisibilityAt(const ShadowVolumeMesh& mesh, Vec3 point, Vec3 normal) {
  return Visibility(mesh, point, normal);
}

float VisibilityAt(const ViewShadow& shadow, Vec3 point, Vec3 /*normal*/) {
  const auto texel = TexelAt(shadow, point);
  return texel ? shadow.visibility.Fraction(texel->i, texel->j) : 0.0f;
}

bool IsInside(const ShadowTexels& texels, Texel texel) {
  return texels.coverage == nullptr || texels.coverage->At(texel.i, texel.j);
}

bool CoversAt(const SoftShadowTexture& texture, Vec3 point) {
  return IsInside(texture, TexelAt(texture, point));
}

bool CoversAt(const AttenuationLdi& /*ldi*/, Vec3 /*point*/) { return true; }

bool CoversAt(const ShadowWidthMap& /*map*/, Vec3 /*point*/) { return true; }

bool CoversAt(const ShadowVolumeMesh& /*mesh*/, Vec3 /*point*/) { return true; }

bool CoversAt(const ViewShadow& shadow, Vec3 point) {
  const auto texel = TexelAt(shadow, point);
  return texel && IsInside(shadow, *texel);
}

struct Texels {
  template <typename Payload>
  const ShadowTexels* operator()(const Payload& payload) const {
    if constexpr (std::is_base_of_v<ShadowTexels, Payload>) {
      return &payload;
    } else {
      return nullptr;
    }
  }
};

}  // namespace

const ShadowTexels* TexelsOf(const ArtifactPayload& payload) {
  return std::visit(Texels{}, payload);
}

ShadowTexels* TexelsOf(ArtifactPayload& payload) {
  return const_cast<ShadowTexels*>(TexelsOf(std::as_const(payload)));
}

const AreaLight& LightOf(const ArtifactPayload& payload) {
  return std::visit([](const auto& one) -> const AreaLight& { return one.light; }, payload);
}

float Visibility(const Artifact& artifact, Vec3 point, Vec3 normal) {
  return std::visit([&](const auto& payload) { return VisibilityAt(payload, point, normal); },
                    artifact.payload);
}

bool Covers(const Artifact& artifact, Vec3 point) {
  return std::visit([&](const auto& payload) { return CoversAt(payload, point); },
                    artifact.payload);
}

}  // namespace penumbra
