#include <array>

#include "render/technique/coherent_raytrace/surface_points.h"

namespace penumbra {
namespace {

// A triangle on a lightmap, in texels, and in the world.
struct Chart {
  std::array<DVec2, 3> texel;
  std::array<DVec3, 3> world;
};

double Cross(DVec2 a, DVec2 b) { return a.x * b.y - a.y * b.x; }

// Puts the chart's surface at the texels whose middle is in it and that are free.
void Cover(const Chart& chart, SurfacePoints& points) {
  const auto& [a, b, c] = chart.texel;
  const double area2 = Cross(b - a, c - a);
  const DVec3 across = glm::cross(chart.world[1] - chart.world[0], chart.world[2] - chart.world[0]);
  const double length = glm::length(across);
  if (area2 == 0 || !(length > 0)) return;
  // A uv may be far outside of the map, beyond what an integer holds.
  const DVec2 size(points.width, points.height);
  const DVec2 min = glm::clamp(glm::min(a, glm::min(b, c)), DVec2(0.0), size);
  const DVec2 max = glm::clamp(glm::max(a, glm::max(b, c)), DVec2(0.0), size);
  for (auto y = static_cast<uint32_t>(min.y); y < max.y; ++y) {
    for (auto x = static_cast<uint32_t>(min.x); x < max.x; ++x) {
      const DVec2 middle(x + 0.5, y + 0.5);
      const double wb = Cross(middle - a, c - a) / area2, wc = Cross(b - a, middle - a) / area2;
      const size_t i = size_t{y} * points.width + x;
      if (!(wb >= 0 && wc >= 0 && wb + wc <= 1) || points.is_there[i]) continue;
      points.points[i] = {
          Vec3((1 - wb - wc) * chart.world[0] + wb * chart.world[1] + wc * chart.world[2]),
          Vec3(across / length)};
      points.is_there[i] = 1;
    }
  }
}

}  // namespace

absl::StatusOr<SurfacePoints> LightmapPoints(const Instance& instance,
                                             const LightmapTexels& lightmap,
                                             const std::stop_token& stop) {
  const Mesh& mesh = *instance.mesh;
  SurfacePoints points = NoPoints(GridOf(lightmap));
  for (size_t t = 0; t < mesh.triangle_count(); ++t) {
    if (stop.stop_requested()) return absl::CancelledError("stopped");
    Chart chart;
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t corner = mesh.indices()[3 * t + k];
      chart.texel[k] = DVec2(mesh.uvs()[corner]) * DVec2(points.width, points.height);
      chart.world[k] = DVec3(TransformPoint(instance.world_from_mesh, mesh.positions()[corner]));
    }
    Cover(chart, points);
  }
  return points;
}

}  // namespace penumbra
