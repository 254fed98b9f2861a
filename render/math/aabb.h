// An axis-aligned bounding box.
#pragma once

#include <limits>

#include "render/math/vec.h"

namespace penumbra {

struct Aabb {
  Vec3 min{std::numeric_limits<float>::infinity()};
  Vec3 max{-std::numeric_limits<float>::infinity()};

  bool empty() const { return !(min.x <= max.x && min.y <= max.y && min.z <= max.z); }
  Vec3 center() const { return 0.5f * (min + max); }
  Vec3 extent() const { return empty() ? Vec3(0.0f) : max - min; }

  void Add(Vec3 p) {
    min = glm::min(min, p);
    max = glm::max(max, p);
  }
  void Add(const Aabb& box) {
    min = glm::min(min, box.min);
    max = glm::max(max, box.max);
  }
};

// The box around the eight transformed corners of `box`; empty stays empty.
Aabb TransformBounds(const Affine& to_from, const Aabb& box);

}  // namespace penumbra
