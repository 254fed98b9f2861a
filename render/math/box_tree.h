// A hierarchy of axis-aligned boxes.
//
//   BoxTree tree(boxes, 4);
//   tree.Visit([&](const Aabb& box) { return region.MayMeet(box); },
//              [&](uint32_t item) { … });   // every item of whose ancestors none was turned down
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/math/aabb.h"

namespace penumbra {

// Halves the items at the median of their middles along the widest side until `leaf_size` or fewer
// remain. The same boxes give the same tree.
//
// Source  Clark 1976, hierarchical bounding volumes
class BoxTree {
 public:
  BoxTree() = default;
  // Shapes  N boxes, none of them empty → items 0 … N − 1
  // Cost    O(N log N) time, 76 bytes an item for leaves of one
  BoxTree(std::span<const Aabb> boxes, uint32_t leaf_size);

  // Calls `visit` for the items of all leaves for which, and for whose ancestors, `may_meet` holds.
  // Neighbours in space come one after another.
  template <typename MayMeet, typename VisitItem>
  void Visit(const MayMeet& may_meet, const VisitItem& visit) const {
    for (uint32_t n = 0; n < nodes_.size();) {
      const Node& node = nodes_[n];
      if (!may_meet(node.box)) {
        n = node.next;
        continue;
      }
      for (uint32_t i = 0; i < node.count; ++i) visit(order_[node.first + i]);
      ++n;
    }
  }

  // Calls `visit` with the items of every leaf.
  template <typename VisitLeaf>
  void VisitLeaves(const VisitLeaf& visit) const {
    for (const Node& node : nodes_) {
      if (node.count > 0) visit(std::span<const uint32_t>(&order_[node.first], node.count));
    }
  }

  size_t bytes() const { return sizeof(Node) * nodes_.size() + sizeof(uint32_t) * order_.size(); }

 private:
  // In the order of a walk from the root, left before right.
  struct Node {
    Aabb box;
    uint32_t next;          // the node after all below this one
    uint32_t first, count;  // items; none: an inner node
  };

  void Build(std::span<const Aabb> boxes, uint32_t first, uint32_t count, uint32_t leaf_size);

  std::vector<Node> nodes_;
  std::vector<uint32_t> order_;
};

}  // namespace penumbra
