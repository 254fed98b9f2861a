#include "render/reference/occluder_triangles.h"

#include <cmath>
#include <cstdint>

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

// The texel that holds `uv`, the mask repeating: worked out here, in double precision, and not by
// AlphaMask, which is among what this room checks.
bool MaskBlocks(const Instance& instance, DVec2 uv) {
  const AlphaMask& mask = *instance.alpha_mask;
  const auto texel = [](double t, uint32_t count) {
    const double scaled = std::fmod(t, 1.0) * count;
    const auto index = static_cast<int64_t>(std::floor(scaled));
    return static_cast<size_t>((index + count) % count);
  };
  const size_t place = texel(uv.y, mask.height()) * mask.width() + texel(uv.x, mask.width());
  return mask.alpha()[place] / 255.0 >= instance.alpha_cutoff;
}

}  // namespace penumbra
