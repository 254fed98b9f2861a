// The vector and matrix types of the project. All of them are GLM's; lengths are metres.
#pragma once

#include <cmath>
#include <glm/glm.hpp>

namespace penumbra {

using Vec2 = glm::vec2;
using Vec3 = glm::vec3;
using Vec4 = glm::vec4;
using Mat4 = glm::mat4;
using DVec2 = glm::dvec2;
using DVec3 = glm::dvec3;
using DVec4 = glm::dvec4;
using DMat4 = glm::dmat4;

// An affine map: four columns of three rows. `world_from_mesh * Vec4(p, 1)` places a point.
using Affine = glm::mat4x3;

inline bool IsFinite(float x) { return std::isfinite(x); }
inline bool IsFinite(Vec2 v) { return std::isfinite(v.x) && std::isfinite(v.y); }
inline bool IsFinite(Vec3 v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
inline bool IsFinite(const Affine& m) {
  return IsFinite(m[0]) && IsFinite(m[1]) && IsFinite(m[2]) && IsFinite(m[3]);
}

inline constexpr Affine IdentityAffine() {
  return Affine(Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(0, 0, 0));
}

inline Vec3 TransformPoint(const Affine& m, Vec3 p) { return m * Vec4(p, 1.0f); }

}  // namespace penumbra
