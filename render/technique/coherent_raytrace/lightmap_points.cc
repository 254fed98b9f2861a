#include <algorithm>
#include <array>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"
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
  const DVec2 min = glm::max(glm::min(a, glm::min(b, c)), DVec2(0.0));
  const DVec2 max = glm::min(glm::max(a, glm::max(b, c)), DVec2(points.width, points.height));
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

absl::StatusOr<SurfacePoints> LightmapPoints(const Instance& instance, uint32_t width,
                                             uint32_t height) {
  if (absl::Status status = CheckPictureSize(width, height); !status.ok()) return status;
  const Mesh& mesh = *instance.mesh;
  if (mesh.uvs().empty()) {
    return FieldError(absl::StatusCode::kFailedPrecondition, "MISSING_UV", "instance",
                      absl::StrCat("found ", instance.id,
                                   ", whose mesh has no uv coordinates, need a mesh with some"));
  }
  SurfacePoints points{.width = width, .height = height};
  points.points.resize(size_t{width} * height);
  points.is_there.resize(size_t{width} * height);
  for (size_t t = 0; t < mesh.triangle_count(); ++t) {
    Chart chart;
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t corner = mesh.indices()[3 * t + k];
      chart.texel[k] = DVec2(mesh.uvs()[corner]) * DVec2(width, height);
      chart.world[k] = DVec3(TransformPoint(instance.world_from_mesh, mesh.positions()[corner]));
    }
    // A uv far outside of the map has no texel there.
    if (std::ranges::all_of(chart.texel, [](DVec2 p) { return std::isfinite(p.x + p.y); })) {
      Cover(chart, points);
    }
  }
  return points;
}

}  // namespace penumbra
