#include "render/technique/soft_texture/gl/caster.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/technique/soft_texture/receiver_transform.h"

namespace penumbra::texture_gl {
namespace {

// Vertices are rounded to this share of their coordinates, twice, on their way into the world.
constexpr double kRounding = 0x1.0p-21;

int FacingOf(const Instance& instance) {
  if (instance.alpha_mask || instance.mesh->closure() == MeshClosure::kOpen) return 0;
  const Affine& m = instance.world_from_mesh;
  const double det = glm::dot(DVec3(m[0]), glm::cross(DVec3(m[1]), DVec3(m[2])));
  return det > 0 ? 1 : det < 0 ? -1 : 0;
}

Caster CasterFor(const Instance& instance, const Parallelogram& patch, DVec3 front) {
  Caster caster{.instance = &instance};
  const Aabb& box = instance.mesh->bounds();
  const Affine& m = instance.world_from_mesh;
  caster.lowest = std::numeric_limits<double>::infinity();
  caster.highest = -caster.lowest;
  double largest = 0;
  for (int c = 0; c < 8; ++c) {
    const DVec3 p((c & 1) ? box.max.x : box.min.x, (c & 2) ? box.max.y : box.min.y,
                  (c & 4) ? box.max.z : box.min.z);
    const DVec3 x = p.x * DVec3(m[0]), y = p.y * DVec3(m[1]), z = p.z * DVec3(m[2]);
    caster.corners[c] = x + y + z + DVec3(m[3]) - DVec3(patch.origin);
    const double height = glm::dot(front, caster.corners[c]);
    caster.lowest = std::min(caster.lowest, height);
    caster.highest = std::max(caster.highest, height);
    const DVec3 size = glm::abs(x) + glm::abs(y) + glm::abs(z) + glm::abs(DVec3(m[3]));
    largest = std::max(largest, size.x + size.y + size.z);
  }
  caster.lowest -= kRounding * largest;
  caster.highest += kRounding * largest;
  caster.facing = FacingOf(instance);
  return caster;
}

DVec4 InTexels(DVec3 row, DVec3 row_w, double texels, double constant) {
  return {texels * row - 0.5 * row_w, constant};
}

}  // namespace

std::vector<Caster> CastersOn(const Scene& scene, const ReceiverPatch& receiver) {
  const Parallelogram& patch = receiver.patch;
  const DVec3 front = glm::normalize(glm::cross(DVec3(patch.edge_u), DVec3(patch.edge_v)));
  std::vector<Caster> casters;
  casters.reserve(scene.instances().size());
  for (const auto& [id, instance] : scene.instances()) {
    if (!instance->casts || instance->mesh->triangle_count() == 0) continue;
    casters.push_back(CasterFor(*instance, patch, front));
  }
  return casters;
}

std::vector<GpuSampleMap> SampleMaps(const ReceiverPatch& receiver,
                                     std::span<const LightSample> samples, double surface_offset,
                                     const std::stop_token& stop) {
  std::vector<GpuSampleMap> maps;
  maps.reserve(samples.size());
  for (const LightSample& sample : samples) {
    if (stop.stop_requested()) break;
    GpuSampleMap& map = maps.emplace_back();
    const auto transform = ReceiverTransform::Create(receiver.patch, sample, surface_offset);
    if (!transform) continue;
    map.row_x = InTexels(transform->row_x(), transform->row_w(), receiver.width, -0.5);
    map.row_y = InTexels(transform->row_y(), transform->row_w(), receiver.height, -0.5);
    map.row_w = DVec4(transform->row_w(), 1);
    const double height = transform->sample_height();
    map.light = {height > 0 ? 1 : -1, std::min(std::abs(height), 1e300), 0, 0};
  }
  return maps;
}

double TexelsCovered(const Caster& caster, const GpuSampleMap& map, const ReceiverPatch& receiver,
                     uint32_t first_row, uint32_t rows) {
  const DVec2 least(0, first_row), most(receiver.width, 1.0 * first_row + rows);
  DVec2 low = most, high = least;
  for (const DVec3& corner : caster.corners) {
    const auto apply = [&](const DVec4& row) { return glm::dot(DVec3(row), corner) + row.w; };
    const double w = apply(map.row_w);
    if (!(w > 0)) return 1.0 * receiver.width * rows;  // its shadow has no end
    const DVec2 at = glm::clamp(DVec2(apply(map.row_x), apply(map.row_y)) / w, least, most);
    low = glm::min(low, at);
    high = glm::max(high, at);
  }
  const DVec2 size = glm::max(high - low, 0.0);
  return size.x * size.y;
}

bool MissesRows(const Caster& caster, std::span<const GpuSampleMap> maps,
                const ReceiverPatch& receiver, uint32_t first_row, uint32_t rows,
                double surface_offset) {
  const double width = receiver.width, low = first_row, high = first_row + rows;
  for (const GpuSampleMap& map : maps) {
    const double highest = map.light.x > 0 ? caster.highest : -caster.lowest;
    if (map.light.x == 0 || highest <= surface_offset) continue;
    bool beyond[5] = {true, true, true, true, true};
    for (const DVec3& corner : caster.corners) {
      const auto apply = [&](const DVec4& row) { return glm::dot(DVec3(row), corner) + row.w; };
      const double x = apply(map.row_x), y = apply(map.row_y), w = apply(map.row_w);
      // A texel of room for the vertices' rounding.
      beyond[0] &= x < -1.5 * w;
      beyond[1] &= x > (width + 0.5) * w;
      beyond[2] &= y < (low - 1.5) * w;
      beyond[3] &= y > (high + 0.5) * w;
      beyond[4] &= w < 0;
    }
    if (!(beyond[0] || beyond[1] || beyond[2] || beyond[3] || beyond[4])) return false;
  }
  return true;
}

}  // namespace penumbra::texture_gl
