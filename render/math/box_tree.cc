#include "render/math/box_tree.h"

#include <algorithm>
#include <numeric>

namespace penumbra {

BoxTree::BoxTree(std::span<const Aabb> boxes, uint32_t leaf_size) : order_(boxes.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  if (!boxes.empty()) Build(boxes, 0, static_cast<uint32_t>(boxes.size()), leaf_size);
}

void BoxTree::Build(std::span<const Aabb> boxes, uint32_t first, uint32_t count,
                    uint32_t leaf_size) {
  const size_t at = nodes_.size();
  Node node{.box = {}, .next = 0, .first = first, .count = count <= leaf_size ? count : 0};
  Aabb middles;
  for (uint32_t i = first; i < first + count; ++i) {
    node.box.Add(boxes[order_[i]]);
    middles.Add(boxes[order_[i]].center());
  }
  nodes_.push_back(node);
  if (node.count == 0) {
    const Vec3 extent = middles.extent();
    const int axis =
        extent.x >= extent.y && extent.x >= extent.z ? 0 : (extent.y >= extent.z ? 1 : 2);
    const auto begin = order_.begin() + first;
    const uint32_t half = count / 2;
    std::nth_element(begin, begin + half, begin + count, [&](uint32_t a, uint32_t b) {
      const float at_a = boxes[a].center()[axis], at_b = boxes[b].center()[axis];
      return at_a != at_b ? at_a < at_b : a < b;
    });
    Build(boxes, first, half, leaf_size);
    Build(boxes, first + half, count - half, leaf_size);
  }
  nodes_[at].next = static_cast<uint32_t>(nodes_.size());
}

}  // namespace penumbra
