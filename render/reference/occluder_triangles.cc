#include "render/reference/occluder_triangles.h"

namespace penumbra {
namespace {

DVec3 ToWorld(const Affine& world_from_mesh, Vec3 p) {
  return DVec3(world_from_mesh[3]) + double{p.x} * DVec3(world_from_mesh[0]) +
         double{p.y} * DVec3(world_from_mesh[1]) + double{p.z} * DVec3(world_from_mesh[2]);
}

}  // namespace

std::vector<OccluderTriangle> OccluderTriangles(const Scene& scene) {
  std::vector<OccluderTriangle> triangles;
  for (const auto& [id, instance] : scene.instances()) {
    if (!instance->casts) continue;
    const Mesh& mesh = *instance->mesh;
    const bool masked = instance->alpha_mask && !mesh.uvs().empty();
    for (size_t t = 0; t < mesh.triangle_count(); ++t) {
      OccluderTriangle triangle;
      for (int k = 0; k < 3; ++k) {
        const uint32_t vertex = mesh.indices()[3 * t + k];
        triangle.corners[k] = ToWorld(instance->world_from_mesh, mesh.positions()[vertex]);
        if (masked) triangle.uvs[k] = DVec2(mesh.uvs()[vertex]);
      }
      if (masked) triangle.masked = instance;
      triangles.push_back(std::move(triangle));
    }
  }
  return triangles;
}

bool MaskBlocks(const Instance& instance, DVec2 uv) {
  return instance.alpha_mask->At(Vec2(uv)) >= instance.alpha_cutoff;
}

}  // namespace penumbra
