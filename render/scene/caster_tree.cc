#include "render/scene/caster_tree.h"

#include <algorithm>

namespace penumbra {
namespace {

// Boxes for one leaf: a test of a box costs as much as going one level down.
constexpr uint32_t kCastersPerLeaf = 2;

// Placing a vertex takes three products and three sums, each wrong by 2⁻²⁴ of |M| |p| + |t| at
// most, and bounds are rounded to single precision once more: seven times that, or less than 2⁻²¹.
constexpr double kPlacingSlack = 0x1.0p-21;

}  // namespace

Aabb CasterBounds(const Instance& instance) {
  const Aabb& box = instance.mesh->bounds();
  if (box.empty() || instance.mesh->triangle_count() == 0) return {};
  const Affine& m = instance.world_from_mesh;
  const DVec3 middle = 0.5 * (DVec3(box.min) + DVec3(box.max));
  const DVec3 half = 0.5 * (DVec3(box.max) - DVec3(box.min));
  DVec3 center(m[3]), reach(0.0), size = glm::abs(DVec3(m[3]));
  for (int c = 0; c < 3; ++c) {
    const DVec3 column(m[c]);
    center += middle[c] * column;
    reach += half[c] * glm::abs(column);
    size += (std::abs(middle[c]) + half[c]) * glm::abs(column);
  }
  reach += kPlacingSlack * size;
  return {Vec3(center - reach), Vec3(center + reach)};
}

CasterTree::CasterTree(const Casters& instances) {
  for (const auto& instance : instances) {
    if (!instance->casts) continue;
    const Aabb bounds = CasterBounds(*instance);
    if (bounds.empty()) continue;
    casters_.push_back(instance);
    bounds_.push_back(bounds);
  }
  tree_ = BoxTree(bounds_, kCastersPerLeaf);
}

}  // namespace penumbra
