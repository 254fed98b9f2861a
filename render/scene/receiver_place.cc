#include "render/scene/receiver_place.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "render/math/aabb.h"
#include "render/scene/field_error.h"
#include "render/scene/flat_bounds.h"
#include "render/scene/planar_surfaces.h"
#include "render/scene/texture_size.h"

namespace penumbra {
namespace {

// Share of the extent by which a vertex may leave the plane: what modellers' files round away, and
// far below a texel.
constexpr double kPlanarTolerance = 1e-4;

absl::Status NotPlanar(const Instance& instance, const std::string& found) {
  return FieldError(
      absl::StatusCode::kFailedPrecondition, "NOT_PLANAR", "instance_id",
      absl::StrCat("found ", instance.id, ", which ", found, ", need an instance in one plane"));
}

absl::Status NoSurface(const Instance& instance, uint32_t triangle, const char* found) {
  return FieldError(absl::StatusCode::kFailedPrecondition, "NOT_PLANAR", "triangle",
                    absl::StrCat("found ", triangle, " of ", instance.id, ", which ", found,
                                 ", need a triangle with an area"));
}

// The corners of some triangles in the world, and the sum of what they span.
struct PlacedTriangles {
  std::vector<DVec3> corners;  // three a triangle
  DVec3 twice_area{0.0};
  double twice_size = 0;
  double extent = 0;

  void Add(const Instance& instance, size_t triangle) {
    const Mesh& mesh = *instance.mesh;
    for (size_t k = 3 * triangle; k < 3 * triangle + 3; ++k) {
      const Vec3 p = TransformPoint(instance.world_from_mesh, mesh.positions()[mesh.indices()[k]]);
      corners.emplace_back(p);
      bounds.Add(p);
    }
    const auto last = std::span(corners).last(3);
    const DVec3 cross = glm::cross(last[1] - last[0], last[2] - last[0]);
    twice_area += cross;
    twice_size += glm::length(cross);
    extent = glm::length(DVec3(bounds.extent()));
  }
  bool has_front() const { return glm::length(twice_area) > 1e-12 * extent * extent; }

  Aabb bounds;
};

// The triangles as parts of the patch around them.
std::shared_ptr<const PlanarRegion> RegionOf(std::span<const DVec3> corners,
                                             const Parallelogram& patch, size_t polygon_size) {
  auto region = std::make_shared<PlanarRegion>();
  region->points.reserve(corners.size());
  std::vector<DVec2> polygon;
  for (size_t i = 0; i < corners.size(); i += polygon_size) {
    polygon.clear();
    for (const DVec3& p : corners.subspan(i, polygon_size)) {
      polygon.push_back(UvOnPatch(patch, p));
    }
    region->Add(polygon);
  }
  return region;
}

absl::StatusOr<PlacedPatch> PlaceShape(const Receiver& receiver, const Instance* instance) {
  if (const std::string* id = InstanceOf(receiver); id != nullptr && instance == nullptr) {
    return FieldError(absl::StatusCode::kFailedPrecondition, "MISSING_INSTANCE", "instance_id",
                      absl::StrCat("found ", *id, ", need an instance of the scene"));
  }
  struct Placer {
    const Instance* instance;

    absl::StatusOr<PlacedPatch> operator()(const Parallelogram& patch) const {
      return PlacedPatch{.patch = patch, .region = nullptr};
    }
    absl::StatusOr<PlacedPatch> operator()(const PlanarInstance&) const {
      return PlaceOnInstance(*instance);
    }
    absl::StatusOr<PlacedPatch> operator()(const Triangle& triangle) const {
      auto region = std::make_shared<PlanarRegion>();
      region->Add(std::array{DVec2(0, 0), DVec2(1, 0), DVec2(0, 1)});
      return PlacedPatch{.patch = {triangle.corner, triangle.edge_u, triangle.edge_v},
                         .region = std::move(region)};
    }
    absl::StatusOr<PlacedPatch> operator()(const PlanarPolygon& polygon) const {
      return PlaceOnPolygon(polygon);
    }
    absl::StatusOr<PlacedPatch> operator()(const PlanarSurface& surface) const {
      return PlaceOnSurface(*instance, surface.triangle);
    }
  };
  return std::visit(Placer{instance}, receiver.shape);
}

}  // namespace

absl::StatusOr<PlacedPatch> PlaceOnInstance(const Instance& instance) {
  PlacedTriangles triangles;
  triangles.corners.reserve(instance.mesh->indices().size());
  for (size_t t = 0; t < instance.mesh->triangle_count(); ++t) triangles.Add(instance, t);
  if (!triangles.has_front()) {
    return NotPlanar(instance, triangles.twice_size > 0 ? "has no front" : "covers no area");
  }
  const DVec3 normal = glm::normalize(triangles.twice_area);
  const DVec3 first = triangles.corners[0];
  for (const DVec3& p : triangles.corners) {
    if (std::abs(glm::dot(p - first, normal)) > kPlanarTolerance * triangles.extent) {
      return NotPlanar(instance, "is not flat");
    }
  }
  const auto bounds = BoundFlat(triangles.corners, normal);
  if (!bounds) return NotPlanar(instance, "is too thin to have an area");
  return PlacedPatch{.patch = bounds->patch,
                     .region = RegionOf(triangles.corners, bounds->patch, 3),
                     .deviation_m = bounds->deviation};
}

absl::StatusOr<PlacedPatch> PlaceOnSurface(const Instance& instance, uint32_t triangle) {
  const PlanarSurfaces& surfaces = instance.mesh->planar_surfaces();
  const auto surface = surfaces.SurfaceOf(triangle);
  if (!surface) {
    const bool is_there = triangle < instance.mesh->triangle_count();
    return NoSurface(instance, triangle, is_there ? "has no area" : "is not there");
  }
  PlacedTriangles triangles;
  for (const uint32_t t : surfaces.Triangles(*surface)) triangles.Add(instance, t);
  if (!triangles.has_front()) return NoSurface(instance, triangle, "covers no area");
  const auto bounds = BoundFlat(triangles.corners, glm::normalize(triangles.twice_area));
  if (!bounds) return NoSurface(instance, triangle, "is on a surface too thin");
  return PlacedPatch{.patch = bounds->patch,
                     .region = RegionOf(triangles.corners, bounds->patch, 3),
                     .deviation_m = bounds->deviation};
}

absl::StatusOr<ReceiverPatch> PlaceReceiver(const Receiver& receiver, const Instance* instance) {
  auto place = PlaceShape(receiver, instance);
  if (!place.ok()) return place.status();
  const double density =
      receiver.texels_per_metre > 0.0f ? receiver.texels_per_metre : kTexelsPerMetre;
  const uint32_t max_side = receiver.max_auto_side > 0 ? receiver.max_auto_side : kMaxAutoSide;
  const auto side = [&](uint32_t wanted, Vec3 edge) {
    return wanted > 0 ? wanted : AutoSide(glm::length(DVec3(edge)), density, max_side);
  };
  return ReceiverPatch{.patch = place->patch,
                       .width = side(receiver.width, place->patch.edge_u),
                       .height = side(receiver.height, place->patch.edge_v),
                       .two_sided = receiver.two_sided,
                       .reflectance = receiver.reflectance,
                       .region = std::move(place->region),
                       .deviation_m = place->deviation_m};
}

}  // namespace penumbra
