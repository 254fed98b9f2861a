// The instances of a scene that cast shadows, in a hierarchy of bounding boxes.
//
//   scene.casters().Visit([&](const Aabb& box) { return region.MayMeet(box); },
//                         [&](const std::shared_ptr<const Instance>& caster) { … });
#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "render/math/box_tree.h"
#include "render/scene/instance.h"

namespace penumbra {

// Around every vertex of `instance` as it is placed in single precision, whatever the rounding;
// empty for a mesh without triangles.
Aabb CasterBounds(const Instance& instance);

class CasterTree {
 public:
  using Casters = std::vector<std::shared_ptr<const Instance>>;

  // Instances that do not cast, or have no triangles, are left out.
  //
  // Cost  O(N log N), 0.1 µs an instance times log N
  explicit CasterTree(const Casters& instances);

  // Calls `visit` with the casters of whose own bounds, and of all bounds around them, `may_meet`
  // holds. Neighbours in space are visited one after another.
  template <typename MayMeet, typename VisitCaster>
  void Visit(const MayMeet& may_meet, const VisitCaster& visit) const {
    tree_.Visit(may_meet, [&](uint32_t i) {
      if (may_meet(bounds_[i])) visit(casters_[i]);
    });
  }

  size_t size() const { return casters_.size(); }
  // CasterBounds of each.
  const std::vector<Aabb>& bounds() const { return bounds_; }

 private:
  Casters casters_;
  std::vector<Aabb> bounds_;  // one a caster
  BoxTree tree_;
};

// The tree of one table of instances, made on first use; any thread may ask.
class CasterTreeOnDemand {
 public:
  template <typename Table>
  const CasterTree& Of(const Table& instances) {
    std::call_once(once_, [&] {
      CasterTree::Casters all;
      all.reserve(instances.size());
      for (const auto& [id, instance] : instances) all.push_back(instance);
      tree_ = std::make_unique<const CasterTree>(all);
    });
    return *tree_;
  }

 private:
  std::once_flag once_;
  std::unique_ptr<const CasterTree> tree_;
};

}  // namespace penumbra
