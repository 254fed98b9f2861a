#include "render/light_view/placed_caster.h"

#include <limits>
#include <utility>

namespace penumbra {
namespace {

constexpr FrameBox kNoBox{.min = Vec3(std::numeric_limits<float>::infinity()),
                          .max = Vec3(-std::numeric_limits<float>::infinity())};

}  // namespace

PlacedCaster::PlacedCaster(const RasterFrame& frame, std::shared_ptr<const Instance> instance,
                           const std::stop_token& stop)
    : frame_(frame), instance_(std::move(instance)), bounds_(kNoBox) {
  const TriangleClusters& clusters = instance_->mesh->triangle_clusters();
  for (auto* axis : {&x_, &y_, &z_}) axis->resize(clusters.vertices.size() + kRasterLanes);
  boxes_.reserve(clusters.size());
  for (size_t c = 0; c < clusters.size() && !stop.stop_requested(); ++c) {
    boxes_.push_back(Place(clusters.first_vertex[c], clusters.first_vertex[c + 1]));
    bounds_.min = glm::min(bounds_.min, boxes_.back().min);
    bounds_.max = glm::max(bounds_.max, boxes_.back().max);
  }
}

FrameBox PlacedCaster::Place(size_t first, size_t end) {
  FrameBox box = kNoBox;
  for (size_t i = first; i < end; ++i) {
    const Vec3 q(PositionOf(instance_->mesh->triangle_clusters().vertices[i]));
    x_[i] = q.x, y_[i] = q.y, z_[i] = q.z;
    box.min = glm::min(box.min, q);
    box.max = glm::max(box.max, q);
  }
  return box;
}

RasterCluster PlacedCaster::Cluster(size_t index) const {
  const TriangleClusters& clusters = instance_->mesh->triangle_clusters();
  const uint32_t vertex = clusters.first_vertex[index];
  const uint32_t triangle = clusters.first_triangle[index];
  return {.x = &x_[vertex],
          .y = &y_[vertex],
          .z = &z_[vertex],
          .vertex_count = clusters.first_vertex[index + 1] - vertex,
          .corners = &clusters.corners[3 * size_t{triangle}],
          .triangle_count = clusters.first_triangle[index + 1] - triangle};
}

const uint32_t* PlacedCaster::VerticesOf(size_t cluster) const {
  const TriangleClusters& clusters = instance_->mesh->triangle_clusters();
  return &clusters.vertices[clusters.first_vertex[cluster]];
}

DVec3 PlacedCaster::PositionOf(uint32_t mesh_vertex) const {
  const Vec3 p = instance_->mesh->positions()[mesh_vertex];
  return frame_.FromWorld(DVec3(TransformPoint(instance_->world_from_mesh, p)));
}

}  // namespace penumbra
