#include "render/technique/shadow_volume/volume_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include "render/artifact/light_extent.h"
#include "render/light_view/view_fit.h"

namespace penumbra {
namespace {

constexpr uint32_t kCubeFaces = 6;

// Face k looks along axis k / 2, up it if k is odd; its columns and rows run up the next two.
int AxisOf(uint32_t face) { return static_cast<int>(face / 2); }
bool IsUp(uint32_t face) { return face % 2 == 1; }

LightFrame CubeFrame(DVec3 center, uint32_t face) {
  DVec3 s(0.0), t(0.0), n(0.0);
  const int axis = AxisOf(face);
  n[axis] = IsUp(face) ? 1 : -1;
  s[(axis + 1) % 3] = 1;
  t[(axis + 2) % 3] = 1;
  return {.origin = center, .axes = {s, t, n}};
}

Aabb BoundsOf(std::span<const Aabb> boxes) {
  Aabb bounds;
  for (const Aabb& box : boxes) bounds.Add(box);
  return bounds;
}

// Whether all of `bounds` is where a light that shines one way does not.
bool IsBehind(const AreaLight& light, const Aabb& bounds) {
  const LightExtent extent(light);
  if (!extent.plane() || extent.plane()->two_sided) return false;
  for (int corner = 0; corner < 8; ++corner) {
    const DVec3 way = CornerOf(bounds, corner) - extent.plane()->point;
    if (glm::dot(way, extent.plane()->normal) > 0) return false;
  }
  return true;
}

// Towards the middle of `bounds`, if all of them is to be seen that way.
std::optional<LightFace> FaceTowards(DVec3 eye, const Aabb& bounds) {
  const DVec3 way = DVec3(bounds.center()) - eye;
  if (!(glm::dot(way, way) > 0)) return std::nullopt;
  LightFace face{.frame = {.origin = eye, .axes = BasisAround(way)}, .window = {}};
  for (int corner = 0; corner < 8; ++corner) {
    const DVec3 q = face.frame.FromWorld(CornerOf(bounds, corner));
    if (!(std::max(std::abs(q.x), std::abs(q.y)) <= kMaxSlope * q.z)) return std::nullopt;
  }
  face.window = WindowOf(face.frame, DVec3(0.0), 0.0, bounds,
                         {.min = DVec2(-kMaxSlope), .max = DVec2(kMaxSlope)});
  return face.window.empty() ? std::nullopt : std::optional(face);
}

// The one face that is enough, if there is one.
std::optional<LightFace> OneFace(const AreaLight& light, const Aabb& bounds) {
  const bool looks_anywhere = std::holds_alternative<PointLight>(light.shape) ||
                              std::holds_alternative<SphereLight>(light.shape);
  if (looks_anywhere) return FaceTowards(LightExtent(light).center(), bounds);
  const std::vector<LightFace> faces = FacesOf(light, bounds);
  return faces.size() == 1 ? std::optional(faces[0]) : std::nullopt;
}

// `cells` from slope −1 to slope 1, with a sample at either end, and the overlap.
LightView CubeView(const LightFrame& frame, uint32_t cells, double far) {
  const double outside = (kVolumeOverlap + 0.5) * 2 / cells;
  const uint32_t side = cells + 1 + 2 * kVolumeOverlap;
  return {.frame = frame,
          .window = {.min = DVec2(-1 - outside), .max = DVec2(1 + outside)},
          .width = side,
          .height = side,
          .near = kNearFraction * far,
          .far = far};
}

}  // namespace

double PitchFor(const AreaLight& light, const Aabb& bounds, uint32_t resolution) {
  if (bounds.empty() || resolution == 0 || IsBehind(light, bounds)) return 0.0;
  const auto face = OneFace(light, bounds);
  const DVec2 size = face ? face->window.size() : DVec2(2.0);
  if (!face && FacesOf(light, bounds).empty()) return 0.0;
  return std::max(size.x, size.y) / resolution;
}

std::vector<VolumeView> VolumeViews(const AreaLight& light, std::span<const Aabb> boxes,
                                    double pitch) {
  const Aabb bounds = BoundsOf(boxes);
  if (bounds.empty() || !(pitch > 0) || IsBehind(light, bounds)) return {};
  if (const auto face = OneFace(light, bounds)) {
    const auto view = CenterView(*face, boxes, pitch);
    if (!view) return {};
    return {{.view = *view, .border = VolumeBorder::kNothing}};
  }
  if (FacesOf(light, bounds).empty()) return {};
  const DVec3 center = LightExtent(light).center();
  double far = 0;
  for (int corner = 0; corner < 8; ++corner) {
    far = std::max(far, glm::distance(CornerOf(bounds, corner), center));
  }
  const double most = kMaxViewSide - 1 - 2 * kVolumeOverlap;
  const auto cells = static_cast<uint32_t>(std::clamp(std::round(2 / pitch), 1.0, most));
  std::vector<VolumeView> views;
  for (uint32_t face = 0; face < kCubeFaces; ++face) {
    views.push_back(
        {.view = CubeView(CubeFrame(center, face), cells, far), .border = VolumeBorder::kOthers});
  }
  return views;
}

void JoinBorders(std::span<DepthMap> maps) {
  if (maps.size() != kCubeFaces) return;
  const int last = static_cast<int>(maps[0].view.width) - 1 - 2 * int{kVolumeOverlap};
  const auto depth_at = [&](uint32_t face, std::array<int, 3> place) -> float& {
    const auto column = static_cast<size_t>(place[(AxisOf(face) + 1) % 3]) + kVolumeOverlap;
    const auto row = static_cast<size_t>(place[(AxisOf(face) + 2) % 3]) + kVolumeOverlap;
    return maps[face].depths[row * maps[face].view.width + column];
  };
  const auto has = [&](uint32_t face, std::array<int, 3> place) {
    return place[AxisOf(face)] == (IsUp(face) ? last : 0);
  };
  for (uint32_t face = 1; face < kCubeFaces; ++face) {
    for (int i = 0; i <= last; ++i) {
      for (const auto& [column, row] : {std::pair(i, 0), {i, last}, {0, i}, {last, i}}) {
        std::array<int, 3> place{};
        place[AxisOf(face)] = IsUp(face) ? last : 0;
        place[(AxisOf(face) + 1) % 3] = column;
        place[(AxisOf(face) + 2) % 3] = row;
        uint32_t first = 0;
        while (!has(first, place)) ++first;
        if (first != face) depth_at(face, place) = depth_at(first, place);
      }
    }
  }
}

}  // namespace penumbra
