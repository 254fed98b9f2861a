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

ViewBall ViewBall::Around(std::span<const DVec4> viewpoints) {
  ViewBall ball;
  for (const DVec4 view : viewpoints) ball.center += view / static_cast<double>(viewpoints.size());
  for (const DVec4 view : viewpoints) {
    ball.radius = std::max(ball.radius, glm::length(DVec3(view - ball.center)));
  }
  return ball;
}

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
  SelectSharedEdges(shared_, moved.xyzw, list);
}

void SilhouetteEdges::FindEach(std::span<const DVec4> viewpoints,
                               std::span<SilhouetteList> lists) const {
  for (size_t first = 0; first < viewpoints.size(); first += kGroupViews) {
    const auto some = viewpoints.subspan(first, std::min(kGroupViews, viewpoints.size() - first));
    const ViewBall ball = ViewBall::Around(some);
    ViewGroup group{.count = some.size(),
                    .radius = static_cast<float>(ball.radius + Slack(ball.center))};
    std::ranges::copy(Moved(ball.center, center_).xyzw, group.center);
    for (size_t v = 0; v < some.size(); ++v) {
      std::ranges::copy(Moved(some[v], center_).xyzw, group.viewpoints[v]);
      AppendBorderEdges(border_, border_count_, group.viewpoints[v], lists[first + v]);
    }
    SelectForEach(shared_, levels_, group, lists.subspan(first, some.size()));
  }
}

double SilhouetteEdges::Slack(DVec4 viewpoint) const {
  return kFacingSlack * (glm::length(DVec3(viewpoint) - viewpoint.w * center_) + extent_);
}

SilhouetteEdges SilhouetteEdges::SeenFrom(const ViewBall& ball) const {
  SilhouetteEdges seen;
  seen.center_ = center_;
  seen.extent_ = extent_;
  seen.border_ = border_;
  seen.border_count_ = border_count_;
  seen.shared_count_ =
      CopySometimes(shared_, shared_count_, levels_, Moved(ball.center, center_).xyzw,
                    static_cast<float>(ball.radius + Slack(ball.center)), seen.shared_);
  return seen;
}

size_t SilhouetteEdges::bytes() const {
  size_t bytes = shared_.size() * sizeof(EdgeCluster) + border_.size() * sizeof(BorderCluster);
  for (const ClusterLevel& level : levels_) bytes += 9 * sizeof(float) * level.x.size();
  return bytes;
}

std::vector<uint32_t> SilhouetteEdges::RenumberVertices(size_t vertex_count) {
  constexpr uint32_t kUnseen = ~0u;
  std::vector<uint32_t> number(vertex_count, kUnseen), used;
  const auto renumber = [&](auto& clusters, size_t count) {
    for (size_t e = 0; e < count; ++e) {
      auto& cluster = clusters[e / kClusterEdges];
      for (auto* vertices : {cluster.from, cluster.to}) {
        uint32_t& vertex = vertices[e % kClusterEdges];
        uint32_t& n = number[vertex];
        if (n == kUnseen) {
          n = static_cast<uint32_t>(used.size());
          used.push_back(vertex);
        }
        vertex = n;
      }
    }
  };
  renumber(shared_, shared_count_);
  renumber(border_, border_count_);
  return used;
}

}  // namespace penumbra
