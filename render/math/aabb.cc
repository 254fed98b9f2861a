#include "render/math/aabb.h"

namespace penumbra {

Aabb TransformBounds(const Affine& to_from, const Aabb& box) {
  Aabb result;
  if (box.empty()) return result;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p((corner & 1) ? box.max.x : box.min.x, (corner & 2) ? box.max.y : box.min.y,
                 (corner & 4) ? box.max.z : box.min.z);
    result.Add(TransformPoint(to_from, p));
  }
  return result;
}

}  // namespace penumbra
