#include "render/light_view/depth_method.h"

#include <algorithm>
#include <cmath>

#include "render/light_view/light_face.h"

namespace penumbra {
namespace {

// Nanoseconds of one thread, on the machine of docs/performance.md.

// A triangle's corners are looked at, and no pixel's centre found between them.
constexpr double kTriangleNs = 3.2;
// One is, so that edges and plane are worked out.
constexpr double kHoldingNs = 63;
constexpr double kMaskedHoldingNs = 175;
// A pixel is filled.
constexpr double kFillNs = 3;
constexpr double kMaskedFillNs = 22;
// A pixel's ray.
constexpr double kRayNs = 27;
// For each doubling of the triangles to a pixel: neighbouring rays part company sooner.
constexpr double kRayDoublingNs = 15;
// A box around a caster that a ray meets; a surface that a mask is asked of.
constexpr double kRayBoxNs = 15;
constexpr double kRayMaskNs = 16;

// Triangles of a caster whose areas are added up; the others are taken to be like them.
constexpr size_t kAreaSamples = 64;

// How many of so many triangles hold a pixel's centre: nearly all where they fill many more pixels
// than they are, as many as pixels where they fill fewer.
double Holding(double triangles, double pixels) {
  return triangles > 0 ? triangles * pixels / (triangles + pixels) : 0;
}

double AreaOf(const Instance& instance) {
  const Mesh& mesh = *instance.mesh;
  const size_t count = std::min(mesh.triangle_count(), kAreaSamples);
  double area = 0;
  for (size_t i = 0; i < count; ++i) {
    const size_t t = i * mesh.triangle_count() / count;
    const auto corner = [&](size_t k) {
      const Vec3 p = mesh.positions()[mesh.indices()[3 * t + k]];
      return DVec3(TransformPoint(instance.world_from_mesh, p));
    };
    const DVec3 a = corner(0);
    area += 0.5 * glm::length(glm::cross(corner(1) - a, corner(2) - a));
  }
  return area / static_cast<double>(count) * static_cast<double>(mesh.triangle_count());
}

double SizeOf(const Window& window) {
  const DVec2 size = glm::max(window.size(), 0.0);
  return size.x * size.y;
}

// Of a box, as wide as it may be.
Window AllOf(const Aabb& box, const LightView& view) {
  constexpr double kWide = 1e9;
  if (view.from_infinity) return ShearedWindow(view.frame, DVec2(view.eye), box);
  return WindowOf(view.frame, view.eye, view.near, box, {DVec2(-kWide), DVec2(kWide)});
}

}  // namespace

double RasterNs(const DepthWork& work) {
  return kTriangleNs * (work.triangles + work.masked_triangles) +
         kHoldingNs * Holding(work.triangles, work.filled) + kFillNs * work.filled +
         kMaskedHoldingNs * Holding(work.masked_triangles, work.masked_filled) +
         kMaskedFillNs * work.masked_filled;
}

double RaysNs(const DepthWork& work) {
  if (work.pixels == 0) return 0;
  const double per_pixel = (work.triangles + work.masked_triangles) / work.pixels;
  return (kRayNs + kRayDoublingNs * std::log2(1 + per_pixel)) * work.pixels +
         kRayBoxNs * work.covered + kRayMaskNs * work.masked_filled;
}

CasterSizes::CasterSizes(const Scene& scene) {
  for (const auto& [id, instance] : scene.instances()) {
    const Mesh& mesh = *instance->mesh;
    if (!instance->casts || mesh.triangle_count() == 0) continue;
    casters_.push_back({.box = WorldBounds(*instance),
                        .triangles = static_cast<double>(mesh.triangle_count()),
                        .area = AreaOf(*instance),
                        .is_masked = instance->alpha_mask && !mesh.uvs().empty()});
  }
}

DepthWork CasterSizes::WorkOf(const LightView& view) const {
  DepthWork work{.pixels = static_cast<double>(view.width) * view.height};
  if (view.empty()) return work;
  const DVec2 scale = view.pixels_per_slope();
  for (const Caster& caster : casters_) {
    const Window all = AllOf(caster.box, view), seen = Intersection(all, view.window);
    if (seen.min.x > seen.max.x || seen.min.y > seen.max.y) continue;
    const double depth = view.frame.FromWorld(DVec3(caster.box.center())).z - view.eye.z;
    const double distance = view.from_infinity ? 1.0 : std::max(depth, view.near);
    // Seen from anywhere a surface looks half as large, on average.
    const double share = SizeOf(all) > 0 ? SizeOf(seen) / SizeOf(all) : 1.0;
    const double filled = 0.5 * caster.area * share * scale.x * scale.y / (distance * distance);
    ++work.casters;
    work.covered += SizeOf(seen) * scale.x * scale.y;
    (caster.is_masked ? work.masked_triangles : work.triangles) += caster.triangles;
    (caster.is_masked ? work.masked_filled : work.filled) += filled;
  }
  return work;
}

}  // namespace penumbra
