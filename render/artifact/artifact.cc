#include "render/artifact/artifact.h"

#include <algorithm>
#include <cmath>

namespace penumbra {
namespace {

// The (u, v) of the point's projection along the patch's normal; least squares in the patch's
// plane.
DVec2 ProjectOntoPatch(const Parallelogram& patch, DVec3 point) {
  const DVec3 u(patch.edge_u), v(patch.edge_v), d = point - DVec3(patch.origin);
  const double uu = glm::dot(u, u), uv = glm::dot(u, v), vv = glm::dot(v, v);
  const double du = glm::dot(d, u), dv = glm::dot(d, v);
  const double det = uu * vv - uv * uv;
  return {(du * vv - dv * uv) / det, (dv * uu - du * uv) / det};
}

uint32_t TexelOf(double t, uint32_t count) {
  return static_cast<uint32_t>(std::clamp(std::floor(t * count), 0.0, count - 1.0));
}

float VisibilityAt(const SoftShadowTexture& texture, Vec3 point) {
  const DVec2 uv = ProjectOntoPatch(texture.receiver.patch, DVec3(point));
  const VisibilityMap& map = texture.visibility;
  return map.Fraction(TexelOf(uv.x, map.width), TexelOf(uv.y, map.height));
}

}  // namespace

float Visibility(const Artifact& artifact, Vec3 point, Vec3 /*normal*/) {
  return std::visit([&](const auto& payload) { return VisibilityAt(payload, point); },
                    artifact.payload);
}

}  // namespace penumbra
