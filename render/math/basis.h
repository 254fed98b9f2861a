// An orthonormal basis around an axis.
#pragma once

#include <cmath>

#include "render/math/vec.h"

namespace penumbra {

// Unit vectors at right angles, right-handed: s × t = n.
struct Basis {
  DVec3 s, t, n;
};

// +z, +x and +y turned the shortest way that takes +y to `axis`: as the axis turns, so does the
// basis, without a jump, but where the axis passes straight through −y.
//
// axis  of any length that is neither 0 nor infinite; becomes `n`
inline Basis BasisAround(DVec3 axis) {
  const DVec3 n = glm::normalize(axis);
  const double across2 = n.x * n.x + n.z * n.z;
  if (n.y < 0 && across2 < 1e-60) return {{0, 0, -1}, {1, 0, 0}, n};
  // 1 / (1 + n.y), without cancellation where n.y is close to −1.
  const double k = n.y < 0 ? (1 - n.y) / across2 : 1 / (1 + n.y);
  const DVec3 s(-n.x * n.z * k, -n.z, n.y < 0 ? n.x * n.x * k + n.y : 1 - n.z * n.z * k);
  const DVec3 t(n.y < 0 ? n.z * n.z * k + n.y : 1 - n.x * n.x * k, -n.x, -n.x * n.z * k);
  return {s, t, n};
}

}  // namespace penumbra
