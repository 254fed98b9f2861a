#include "render/scene/triangle_clusters.h"

#include <algorithm>
#include <limits>

namespace penumbra {
namespace {

constexpr uint32_t kNowhere = std::numeric_limits<uint32_t>::max();

// Appends the triangles of one cluster.
class ClusterWriter {
 public:
  ClusterWriter(std::span<const Vec3> positions, std::span<const uint32_t> indices,
                TriangleClusters& out)
      : positions_(positions), indices_(indices), out_(out), place_(positions.size(), kNowhere) {}

  void Write(std::span<const uint32_t> triangles) {
    const auto first = static_cast<uint32_t>(out_.vertices.size());
    out_.first_vertex.push_back(first);
    out_.first_triangle.push_back(static_cast<uint32_t>(out_.corners.size() / 3));
    Aabb& bounds = out_.bounds.emplace_back();
    for (const uint32_t t : triangles) {
      for (const uint32_t vertex : indices_.subspan(size_t{3} * t, 3)) {
        if (place_[vertex] == kNowhere) {
          place_[vertex] = static_cast<uint32_t>(out_.vertices.size()) - first;
          out_.vertices.push_back(vertex);
          bounds.Add(positions_[vertex]);
        }
        out_.corners.push_back(static_cast<uint16_t>(place_[vertex]));
      }
    }
    for (size_t v = first; v < out_.vertices.size(); ++v) place_[out_.vertices[v]] = kNowhere;
  }

 private:
  std::span<const Vec3> positions_;
  std::span<const uint32_t> indices_;
  TriangleClusters& out_;
  std::vector<uint32_t> place_;  // of a vertex among the cluster's
};

}  // namespace

size_t TriangleClusters::bytes() const {
  return sizeof(uint32_t) * (first_vertex.size() + first_triangle.size() + vertices.size()) +
         sizeof(uint16_t) * corners.size() + sizeof(Aabb) * bounds.size() + tree.bytes();
}

TriangleClusters ClusterTriangles(std::span<const Vec3> positions,
                                  std::span<const uint32_t> indices) {
  std::vector<Aabb> boxes(indices.size() / 3);
  for (size_t t = 0; t < boxes.size(); ++t) {
    for (const uint32_t vertex : indices.subspan(3 * t, 3)) boxes[t].Add(positions[vertex]);
  }
  const BoxTree by_place(boxes, kClusterTriangles);

  TriangleClusters clusters;
  clusters.corners.reserve(indices.size());
  ClusterWriter writer(positions, indices, clusters);
  by_place.VisitLeaves([&](std::span<const uint32_t> leaf) { writer.Write(leaf); });
  clusters.first_vertex.push_back(static_cast<uint32_t>(clusters.vertices.size()));
  clusters.first_triangle.push_back(static_cast<uint32_t>(clusters.corners.size() / 3));
  clusters.tree = BoxTree(clusters.bounds, 1);
  return clusters;
}

}  // namespace penumbra
