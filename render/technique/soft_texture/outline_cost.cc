#include "render/technique/soft_texture/outline_cost.h"

namespace penumbra {

OutlineWork WorkOf(const OutlinedOccluder& occluder) {
  const Instance& instance = occluder.instance();
  const Mesh& mesh = *instance.mesh;
  OutlineWork work{.faces = mesh.triangle_count(),
                   .faces_in_region = mesh.triangle_count(),
                   .border_edges = mesh.silhouette_edges().border_edge_count()};
  if (!occluder.frame().region || mesh.triangle_count() <= kClusterTriangles) return work;
  const TriangleClusters& clusters = mesh.triangle_clusters();
  const ShadowRegion region =
      occluder.frame().region->InMesh(instance.world_from_mesh, mesh.bounds());
  work.faces_in_region = 0;
  clusters.tree.Visit([&](const Aabb& box) { return region.MayMeetByFaces(box); },
                      [&](uint32_t c) {
                        work.faces_in_region +=
                            clusters.first_triangle[c + 1] - clusters.first_triangle[c];
                      });
  return work;
}

void ShadowRectangle::Add(const Aabb& box) {
  for (int corner = 0; corner < 8; ++corner) {
    const DVec3 p = texture_.map.FromOffset({(corner & 1) ? box.max.x : box.min.x,
                                             (corner & 2) ? box.max.y : box.min.y,
                                             (corner & 4) ? box.max.z : box.min.z});
    const bool is_below = p.z > 1e-3;
    low_ = glm::min(low_, is_below ? DVec2(p) / p.z : DVec2(0.0));
    high_ = glm::max(high_, is_below ? DVec2(p) / p.z : DVec2(1.0));
  }
}

double ShadowRectangle::Texels() const {
  const DVec2 size = glm::max(glm::min(high_, 1.0) - glm::max(low_, 0.0), DVec2(0.0));
  return size.x * texture_.width * size.y * texture_.height;
}

}  // namespace penumbra
