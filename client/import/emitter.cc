#include "client/import/emitter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/scene/receiver.h"

namespace penumbra {
namespace {

// How much of the parallelogram around a flat mesh its faces may leave out or cover twice.
constexpr double kAreaTolerance = 1e-3;
// How far from round a tessellated ball's vertices may be; its chords are shorter, its corners not.
constexpr float kRadiusTolerance = 0.01f;
// A tetrahedron's and a box's corners lie on a sphere too.
constexpr size_t kFewestSphereTriangles = 60;
// Share of the sphere's area; a ball of 60 triangles has 0.9.
constexpr double kFewestSphereArea = 0.85;

double WorldArea(const Instance& instance) {
  const auto positions = instance.mesh->positions();
  const auto indices = instance.mesh->indices();
  double area = 0.0;
  for (size_t i = 0; i + 2 < indices.size(); i += 3) {
    const DVec3 a = TransformPoint(instance.world_from_mesh, positions[indices[i]]);
    const DVec3 b = TransformPoint(instance.world_from_mesh, positions[indices[i + 1]]);
    const DVec3 c = TransformPoint(instance.world_from_mesh, positions[indices[i + 2]]);
    area += 0.5 * glm::length(glm::cross(b - a, c - a));
  }
  return area;
}

bool IsMirrored(const Affine& m) { return glm::dot(glm::cross(m[0], m[1]), m[2]) < 0.0f; }

std::optional<LightShape> Rectangle(const Instance& instance, Vec3 radiance, bool two_sided) {
  const absl::StatusOr<Parallelogram> patch = BoundingParallelogram(instance);
  if (!patch.ok()) return std::nullopt;
  const double patch_area = glm::length(glm::cross(DVec3(patch->edge_u), DVec3(patch->edge_v)));
  if (!(patch_area > 0.0)) return std::nullopt;
  if (std::abs(WorldArea(instance) / patch_area - 1.0) > kAreaTolerance) return std::nullopt;
  RectangleLight light{.corner = patch->origin,
                       .edge_u = patch->edge_u,
                       .edge_v = patch->edge_v,
                       .radiance = radiance,
                       .two_sided = two_sided};
  if (IsMirrored(instance.world_from_mesh)) std::swap(light.edge_u, light.edge_v);
  return light;
}

std::optional<LightShape> Sphere(const Instance& instance, Vec3 radiance) {
  if (instance.mesh->triangle_count() < kFewestSphereTriangles) return std::nullopt;
  Aabb box;
  for (const uint32_t i : instance.mesh->indices()) {
    box.Add(TransformPoint(instance.world_from_mesh, instance.mesh->positions()[i]));
  }
  const Vec3 center = box.center();
  const float radius = 0.5f * std::max({box.extent().x, box.extent().y, box.extent().z});
  for (const uint32_t i : instance.mesh->indices()) {
    const Vec3 p = TransformPoint(instance.world_from_mesh, instance.mesh->positions()[i]);
    if (std::abs(glm::distance(p, center) - radius) > kRadiusTolerance * radius) {
      return std::nullopt;
    }
  }
  // A dome or a ring of a ball covers less.
  const double whole = 4.0 * std::numbers::pi * double{radius} * double{radius};
  if (!(radius > 0.0f) || WorldArea(instance) < kFewestSphereArea * whole) return std::nullopt;
  return SphereLight{.center = center, .radius = radius, .radiance = radiance};
}

}  // namespace

std::optional<LightShape> EmitterShape(const Instance& instance, Vec3 radiance, bool two_sided) {
  if (!instance.mesh || instance.mesh->triangle_count() == 0) return std::nullopt;
  if (auto rectangle = Rectangle(instance, radiance, two_sided)) return rectangle;
  return Sphere(instance, radiance);
}

}  // namespace penumbra
