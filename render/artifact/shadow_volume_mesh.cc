#include "render/artifact/shadow_volume_mesh.h"

#include <array>
#include <cstdlib>
#include <utility>
#include <variant>

#include "render/artifact/light_above_plane.h"
#include "render/artifact/light_extent.h"

namespace penumbra {
namespace {

// Twice the area of the triangle (0, a, b) as `axis` sees it.
double Side(DVec3 axis, DVec3 a, DVec3 b) { return glm::dot(axis, glm::cross(a, b)); }

// Whether the way from 0 towards the light's centre meets the triangle.
bool Blocks(const std::array<DVec3, 3>& corners, DVec3 to_light, bool is_far) {
  const double ab = Side(to_light, corners[0], corners[1]);
  const double bc = Side(to_light, corners[1], corners[2]);
  const double ca = Side(to_light, corners[2], corners[0]);
  // What meets an edge meets both its triangles, so that nothing slips through between.
  const bool in_front = ab >= 0 && bc >= 0 && ca >= 0, behind = ab <= 0 && bc <= 0 && ca <= 0;
  if (in_front == behind) return false;
  const DVec3 normal = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
  const double t = glm::dot(normal, corners[0]) / glm::dot(normal, to_light);
  return t > 0 && (is_far || t < 1);
}

bool IsBehindCaster(const ShadowVolume& volume, const AreaLight& light, DVec3 point) {
  const DVec4 middle = PlaceOfMiddle(light);
  const bool is_far = middle.w == 0;
  const DVec3 to_light = DVec3(middle) - middle.w * point;
  for (size_t i = 0; i + 2 < volume.caster_indices.size(); i += 3) {
    std::array<DVec3, 3> corners;
    for (size_t k = 0; k < 3; ++k) {
      const Vec4 v = volume.vertices[volume.caster_indices[i + k]];
      corners[k] = DVec3(v) / double{v.w} - point;
    }
    if (Blocks(corners, to_light, is_far)) return true;
  }
  return false;
}

// Whether the first of the faces that covers the point has something before it.
bool IsBehind(const std::vector<VolumeGrid>& grids, DVec3 point) {
  for (const VolumeGrid& grid : grids) {
    const VolumeGrid::Place place = grid.PlaceOf(point);
    if (place.is_ahead && grid.Covers(place.at)) {
      return grid.NearnessAt(place.at) > place.nearness;
    }
  }
  return false;
}

// The same without grids, from the four samples around the point.
bool IsBehind(const std::vector<VolumeFace>& faces, float bias_px, DVec3 point) {
  for (const VolumeFace& face : faces) {
    const VolumeFrame frame(face.map.view, face.border);
    const VolumeFrame::Place place = frame.PlaceOf(point);
    if (!place.is_ahead || !frame.Covers(place.at)) continue;
    const VolumeFrame::Cell cell = frame.CellAt(place.at);
    const auto sample = [&](uint32_t x, uint32_t y) {
      const uint32_t at_x = x - frame.ring(), at_y = y - frame.ring();  // in the ring: huge
      const LightView& view = face.map.view;
      if (at_x >= view.width || at_y >= view.height) return frame.nothing();
      return frame.NearnessOf(face.map.depths[size_t{at_y} * view.width + at_x], bias_px);
    };
    const CellCorners corners = {sample(cell.x, cell.y), sample(cell.x + 1, cell.y),
                                 sample(cell.x + 1, cell.y + 1), sample(cell.x, cell.y + 1)};
    return NearnessWithin(corners, cell.within) > place.nearness;
  }
  return false;
}

}  // namespace

size_t ShadowVolume::weighed_triangle_count() const {
  if (weights.empty()) return triangle_count();
  size_t count = 0;
  for (const int8_t weight : weights) count += static_cast<size_t>(std::abs(int{weight}));
  return count;
}

size_t ShadowVolume::sample_count() const {
  size_t count = 0;
  for (const VolumeFace& face : faces) count += face.map.depths.size();
  return count;
}

size_t ShadowVolume::bytes() const {
  return vertices.size() * sizeof(Vec4) + weights.size() +
         (indices.size() + caster_indices.size()) * sizeof(uint32_t) +
         sample_count() * sizeof(float);
}

size_t ShadowVolumeMesh::triangle_count() const {
  size_t count = 0;
  for (const auto& volume : volumes) count += volume->triangle_count();
  return count;
}

size_t ShadowVolumeMesh::sample_count() const {
  size_t count = 0;
  for (const auto& volume : volumes) count += volume->sample_count();
  return count;
}

size_t ShadowVolumeMesh::bytes() const {
  size_t bytes = 0;
  for (const auto& volume : volumes) bytes += volume->bytes();
  return bytes;
}

VolumeLookup::VolumeLookup(const ShadowVolumeMesh& mesh) : mesh_(mesh) {
  for (const auto& volume : mesh.volumes) {
    Surfaces surfaces{.volume = volume.get(), .grids = {}};
    for (const VolumeFace& face : volume->faces) {
      surfaces.grids.emplace_back(face.map, face.border, mesh.bias_px);
    }
    surfaces_.push_back(std::move(surfaces));
  }
}

int VolumeLookup::Depth(DVec3 point) const {
  int depth = 0;
  for (const Surfaces& surfaces : surfaces_) {
    depth += surfaces.volume->kind == VolumeKind::kObject
                 ? IsBehindCaster(*surfaces.volume, mesh_.light, point)
                 : IsBehind(surfaces.grids, point);
  }
  return depth;
}

float VolumeLookup::Visibility(Vec3 point, Vec3 normal) const {
  if (!(LightAbovePlane(mesh_.light, point, normal) > 0)) return 0.0f;
  return Depth(DVec3(point)) > 0 ? 0.0f : 1.0f;
}

float Visibility(const ShadowVolumeMesh& mesh, Vec3 point, Vec3 normal) {
  if (!(LightAbovePlane(mesh.light, point, normal) > 0)) return 0.0f;
  for (const auto& volume : mesh.volumes) {
    const bool is_dark = volume->kind == VolumeKind::kObject
                             ? IsBehindCaster(*volume, mesh.light, DVec3(point))
                             : IsBehind(volume->faces, mesh.bias_px, DVec3(point));
    if (is_dark) return 0.0f;
  }
  return 1.0f;
}

}  // namespace penumbra
