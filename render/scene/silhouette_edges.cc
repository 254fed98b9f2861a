#include "render/scene/silhouette_edges.h"

#include <algorithm>

#include "render/scene/silhouette_kernel.h"

namespace penumbra {
namespace {

struct Viewpoint {
  float xyzw[4];
};

Viewpoint Moved(DVec4 viewpoint, DVec3 center) {
  const DVec3 moved = DVec3(viewpoint) - viewpoint.w * center;
  return {{static_cast<float>(moved.x), static_cast<float>(moved.y), static_cast<float>(moved.z),
           static_cast<float>(viewpoint.w)}};
}

}  // namespace

void SilhouetteList::Reserve(size_t more) {
  const size_t need = count + more + kClusterEdges;
  if (weight.size() >= need) return;
  const size_t size = std::max(need, 2 * weight.size());
  from.resize(size);
  to.resize(size);
  weight.resize(size);
}

void SilhouetteEdges::Find(DVec4 viewpoint, SilhouetteList& list) const {
  const Viewpoint moved = Moved(viewpoint, center_);
  AppendBorderEdges(border_, border_count_, moved.xyzw, list);
  if (levels_.empty()) {
    SelectSharedEdges(shared_, 0, shared_count_, moved.xyzw, list);
  } else {
    SelectByClusters(shared_, levels_, moved.xyzw, list);
  }
}

void SilhouetteEdges::FindOneByOne(DVec4 viewpoint, SilhouetteList& list) const {
  const Viewpoint moved = Moved(viewpoint, center_);
  AppendBorderEdges(border_, border_count_, moved.xyzw, list);
  SelectSharedEdges(shared_, 0, shared_count_, moved.xyzw, list);
}

SilhouetteEdges SilhouetteEdges::SeenFrom(const ViewBall& ball) const {
  const Viewpoint moved = Moved(ball.center, center_);
  // What rounding may do to a height.
  const double slack =
      kFacingSlack * (glm::length(DVec3(ball.center) - ball.center.w * center_) + extent_);
  std::vector<uint32_t> found;
  SelectSometimes(shared_, shared_count_, levels_, moved.xyzw,
                  static_cast<float>(ball.radius + slack), found);
  SilhouetteEdges seen;
  seen.center_ = center_;
  seen.extent_ = extent_;
  seen.border_ = border_;
  seen.border_count_ = border_count_;
  seen.shared_count_ = found.size();
  const auto take = [&](const auto& from, auto& to) {
    to.resize((found.size() + 2 * kClusterEdges - 1) / kClusterEdges * kClusterEdges);
    for (size_t e = 0; e < found.size(); ++e) to[e] = from[found[e]];
  };
  take(shared_.from, seen.shared_.from);
  take(shared_.to, seen.shared_.to);
  for (FacePlanes EdgeArrays::*side : {&EdgeArrays::left, &EdgeArrays::right}) {
    for (auto values : {&FacePlanes::x, &FacePlanes::y, &FacePlanes::z, &FacePlanes::offset}) {
      take((shared_.*side).*values, (seen.shared_.*side).*values);
    }
  }
  return seen;
}

size_t SilhouetteEdges::bytes() const {
  // Two vertices and two planes of four numbers an edge, nine numbers a cluster.
  size_t numbers = 10 * (shared_.from.size() + border_.from.size());
  for (const ClusterLevel& level : levels_) numbers += 9 * level.x.size();
  return sizeof(float) * numbers;
}

std::vector<uint32_t> SilhouetteEdges::RenumberVertices(size_t vertex_count) {
  constexpr uint32_t kUnseen = ~0u;
  std::vector<uint32_t> number(vertex_count, kUnseen), used;
  const auto renumber = [&](std::vector<uint32_t>& vertices, size_t count) {
    for (size_t e = 0; e < count; ++e) {
      uint32_t& n = number[vertices[e]];
      if (n == kUnseen) {
        n = static_cast<uint32_t>(used.size());
        used.push_back(vertices[e]);
      }
      vertices[e] = n;
    }
  };
  for (auto vertices : {&EdgeArrays::from, &EdgeArrays::to}) {
    renumber(shared_.*vertices, shared_count_);
    renumber(border_.*vertices, border_count_);
  }
  return used;
}

}  // namespace penumbra
