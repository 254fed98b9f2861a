#include "tests/support/volume_masks.h"

#include <algorithm>
#include <cmath>

#include "render/artifact/volume_cap.h"
#include "render/math/basis.h"
#include "render/math/parallel_for.h"

namespace penumbra::testing {
namespace {

struct Masks {
  const MaskCase& c;
  EyeView view;
  std::vector<uint8_t> by_mesh, by_rays, by_map;

  Masks(const MaskCase& mask_case, tbb::task_arena& arena)
      : c(mask_case), view(c.rays.See(c.eye, arena)) {
    by_mesh = c.drawn.empty() ? MaskOf(c.mesh, c.eye, view) : c.drawn;
    by_rays = c.rays.Shadow(view, c.light, c.offset, arena);
    by_map.resize(by_mesh.size());
    const VolumeLookup lookup(c.mesh);
    RunIn(arena, [&] {
      ParallelFor(by_mesh.size(), [&](size_t pixel) {
        if (view.inverse_depths[pixel] == 0) return;
        const DVec3 point(view.points[pixel]);
        if (glm::dot(ToLight(pixel), DVec3(view.normals[pixel])) <= 0) {
          by_mesh[pixel] = by_map[pixel] = 1;  // as shading has it
          return;
        }
        by_map[pixel] = lookup.Depth(point) > 0;
      });
    });
  }

  DVec3 ToLight(size_t pixel) const {
    return DVec3(c.light) - c.light.w * DVec3(view.points[pixel]);
  }

  // A texel of the first map at the point, across the light's ray, in m; 0: there is no map.
  double Texel(size_t pixel) const {
    for (const auto& volume : c.mesh.volumes) {
      if (!volume->faces.empty()) return Texel(pixel, volume->faces.front().map.view);
    }
    return 0;
  }
  double Texel(size_t pixel, const LightView& map) const {
    return (c.light.w == 0 ? 1.0 : glm::length(ToLight(pixel))) * map.window.size().x / map.width;
  }

  double Slant(size_t pixel) const {
    const double slant = glm::dot(glm::normalize(ToLight(pixel)), DVec3(view.normals[pixel]));
    return std::max(std::abs(slant), 0.01);
  }

  // Two of the map's texels as the picture shows them there, in pixels.
  double TwoTexels(size_t pixel) const {
    // A pixel's size at depth 1: from the scale of y in the projection.
    const DMat4& m = c.eye.clip_from_world;
    const double scale = 0.5 * c.eye.height * glm::length(DVec3(m[0][1], m[1][1], m[2][1]));
    return 2 * Texel(pixel) * scale * view.inverse_depths[pixel] / Slant(pixel);
  }

  // Whether the plane of the surface, were it larger, would have another shadow within two texels.
  bool IsNearBoundaryOnPlane(size_t pixel, tbb::task_arena& arena) const {
    constexpr int kWays = 16;
    const DVec3 way = glm::normalize(ToLight(pixel)), normal(view.normals[pixel]);
    const Basis around = BasisAround(way);
    EyeView places;
    for (int k = 0; k < 2 * kWays; ++k) {
      const double angle = 6.283185307 * k / kWays, radius = (1 + k / kWays) * Texel(pixel);
      const DVec3 off = radius * (std::cos(angle) * around.s + std::sin(angle) * around.t);
      const DVec3 slid = off - glm::dot(off, normal) / glm::dot(way, normal) * way;
      places.inverse_depths.push_back(1);
      places.points.push_back(view.points[pixel] + Vec3(slid));
      places.normals.push_back(view.normals[pixel]);
    }
    for (const uint8_t dark : c.rays.Shadow(places, c.light, c.offset, arena)) {
      if (dark != by_rays[pixel]) return true;
    }
    return false;
  }

  // Whether the rays' shadow has a boundary within so many pixels.
  bool IsNearBoundary(size_t pixel, double radius) const {
    const int x = static_cast<int>(pixel % c.eye.width), y = static_cast<int>(pixel / c.eye.width);
    const int reach = static_cast<int>(std::ceil(radius)) + 1;
    for (int v = std::max(0, y - reach); v <= std::min<int>(c.eye.height - 1, y + reach); ++v) {
      for (int u = std::max(0, x - reach); u <= std::min<int>(c.eye.width - 1, x + reach); ++u) {
        const size_t other = static_cast<size_t>(v) * c.eye.width + static_cast<size_t>(u);
        if (std::hypot(u - x, v - y) > radius + 1 || view.inverse_depths[other] == 0) continue;
        if (by_rays[other] != by_rays[pixel]) return true;
      }
    }
    return false;
  }
};

}  // namespace

void MaskComparison::Add(const MaskComparison& other) {
  pixels += other.pixels;
  not_as_rays += other.not_as_rays;
  astray += other.astray;
  not_as_map += other.not_as_map;
  map_not_as_rays += other.map_not_as_rays;
  largest_unlike_map = std::max(largest_unlike_map, other.largest_unlike_map);
  largest_astray = std::max(largest_astray, other.largest_astray);
}

std::vector<uint8_t> MaskOf(const ShadowVolumeMesh& mesh, const EyeImage& eye,
                            const EyeView& view) {
  std::vector<uint8_t> mask(view.inverse_depths.size());
  for (const auto& shared : mesh.volumes) {
    const ShadowVolume& volume = *shared;
    VolumeCrossings crossings(eye, view.inverse_depths);
    crossings.Add(volume.vertices, volume.indices, volume.weights);
    const VolumeCaps caps =
        VolumeCapper(volume, mesh.bias_px, mesh.light).CapsFor(eye.clip_from_world, eye.near);
    crossings.AddCaps(caps.corners);
    if (caps.inverts) crossings.Invert();
    const bool counts = volume.kind == VolumeKind::kObject;
    for (size_t pixel = 0; pixel < mask.size(); ++pixel) {
      if (view.inverse_depths[pixel] == 0) continue;
      mask[pixel] |= counts ? crossings.Count(pixel) != 0 : crossings.IsOdd(pixel);
    }
  }
  return mask;
}

MaskComparison CompareMasks(const MaskCase& c, tbb::task_arena& arena) {
  const Masks masks(c, arena);
  MaskComparison result{.pixels = masks.by_mesh.size()};
  std::vector<uint8_t> astray(result.pixels), unlike_map(result.pixels);
  for (size_t pixel = 0; pixel < result.pixels; ++pixel) {
    if (masks.view.inverse_depths[pixel] == 0) continue;
    const bool is_unlike = masks.by_mesh[pixel] != masks.by_map[pixel];
    result.not_as_map += is_unlike;
    unlike_map[pixel] = is_unlike && masks.by_mesh[pixel] != masks.by_rays[pixel];
    result.map_not_as_rays += masks.by_map[pixel] != masks.by_rays[pixel];
    if (masks.by_mesh[pixel] == masks.by_rays[pixel]) continue;
    ++result.not_as_rays;
    astray[pixel] = !masks.IsNearBoundary(pixel, masks.TwoTexels(pixel)) &&
                    !masks.IsNearBoundaryOnPlane(pixel, arena);
    result.astray += astray[pixel];
  }
  result.largest_unlike_map = LargestPart(unlike_map, c.eye.width);
  result.largest_astray = LargestPart(astray, c.eye.width);
  return result;
}

size_t LargestPart(const std::vector<uint8_t>& set, uint32_t width) {
  std::vector<uint8_t> left = set;
  size_t largest = 0;
  std::vector<size_t> open;
  for (size_t start = 0; start < left.size(); ++start) {
    if (!left[start]) continue;
    size_t size = 0;
    open.push_back(start);
    left[start] = 0;
    const auto visit = [&](size_t pixel, bool is_inside) {
      if (!is_inside || !left[pixel]) return;
      left[pixel] = 0;
      open.push_back(pixel);
    };
    while (!open.empty()) {
      const size_t pixel = open.back();
      open.pop_back();
      ++size;
      visit(pixel - 1, pixel % width > 0);
      visit(pixel + 1, pixel % width + 1 < width);
      visit(pixel - width, pixel >= width);
      visit(pixel + width, pixel + width < left.size());
    }
    largest = std::max(largest, size);
  }
  return largest;
}

}  // namespace penumbra::testing
