#include "render/scene/surface_receivers.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <tuple>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"
#include "render/scene/receiver_place.h"
#include "render/scene/scene.h"
#include "render/scene/texture_size.h"

namespace penumbra {
namespace {

void AddSurfaces(const Instance& instance, double min_area_m2, std::vector<FoundSurface>& found) {
  const Mesh& mesh = *instance.mesh;
  std::vector<DVec3> world;
  world.reserve(mesh.vertex_count());
  for (const Vec3& p : mesh.positions()) {
    world.emplace_back(TransformPoint(instance.world_from_mesh, p));
  }
  const PlanarSurfaces& surfaces = mesh.planar_surfaces();
  for (size_t s = 0; s < surfaces.count(); ++s) {
    double area = 0;
    for (const uint32_t t : surfaces.Triangles(s)) {
      const auto corners = mesh.indices().subspan(3 * size_t{t}, 3);
      const DVec3 a = world[corners[0]];
      area += 0.5 * glm::length(glm::cross(world[corners[1]] - a, world[corners[2]] - a));
    }
    if (area > 0 && area >= min_area_m2) {
      found.push_back({instance.id, surfaces.Triangles(s).front(), area});
    }
  }
}

absl::Status CheckRequest(const PlanarSurfaceRequest& request, const std::string& path,
                          const SceneLimits& limits) {
  const auto check = [&](const char* field, double found, double most) {
    if (found >= 0 && found <= most) return absl::OkStatus();
    return FieldError(absl::StatusCode::kInvalidArgument,
                      std::isfinite(found) ? "RANGE" : "NON_FINITE", absl::StrCat(path, field),
                      absl::StrCat("found ", found, ", need 0 to ", most));
  };
  for (const absl::Status& status :
       {check(".min_area_m2", request.min_area_m2, 1e18),
        check(".texels_per_metre", request.texels_per_metre, kMaxTexelsPerMetre),
        check(".max_auto_side", request.max_auto_side, limits.max_receiver_side),
        check(".max_receivers", request.max_receivers, static_cast<double>(limits.max_receivers)),
        CheckId(request.id_prefix, path + ".id_prefix")}) {
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

// Meshes whose surfaces are still to be found cost time that a commit waits for.
absl::Status CheckTriangles(const InstanceTable& instances, const std::string& path,
                            const SceneLimits& limits) {
  std::set<const Mesh*> meshes;
  uint64_t triangles = 0;
  for (const auto& [id, instance] : instances) {
    if (!instance->receives || !meshes.insert(instance->mesh.get()).second) continue;
    triangles += instance->mesh->triangle_count();
  }
  if (triangles <= limits.max_surface_triangles) return absl::OkStatus();
  return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_SURFACE_TRIANGLES", path,
                    absl::StrCat("found ", triangles,
                                 " triangles in meshes that receive, need at "
                                 "most ",
                                 limits.max_surface_triangles));
}

}  // namespace

std::string SurfaceReceiverId(const std::string& prefix, const FoundSurface& surface,
                              uint32_t max_id_bytes) {
  const std::string tail = absl::StrCat(".", surface.triangle);
  std::string id = absl::StrCat(prefix, surface.instance_id, tail);
  if (id.size() <= max_id_bytes) return id;
  const std::string hash = Sha256(std::as_bytes(std::span(surface.instance_id))).hex();
  return absl::StrCat(prefix, hash.substr(0, 16), tail);
}

std::vector<FoundSurface> FindPlanarSurfaces(const InstanceTable& instances, double min_area_m2,
                                             size_t max_count) {
  std::vector<FoundSurface> found;
  for (const auto& [id, instance] : instances) {
    if (instance->receives) AddSurfaces(*instance, min_area_m2, found);
  }
  const auto before = [](const FoundSurface& a, const FoundSurface& b) {
    return std::tie(b.area_m2, a.instance_id, a.triangle) <
           std::tie(a.area_m2, b.instance_id, b.triangle);
  };
  std::sort(found.begin(), found.end(), before);
  std::vector<FoundSurface> placed;
  for (FoundSurface& surface : found) {
    if (placed.size() == max_count) break;
    // One that is too thin has no patch around it.
    const auto instance = instances.find(surface.instance_id);
    if (PlaceOnSurface(*instance->second, surface.triangle).ok()) {
      placed.push_back(std::move(surface));
    }
  }
  return placed;
}

absl::StatusOr<std::vector<Receiver>> ReceiversOnSurfaces(const InstanceTable& instances,
                                                          const PlanarSurfaceRequest& request,
                                                          const std::string& path,
                                                          const SceneLimits& limits) {
  if (const auto status = CheckRequest(request, path, limits); !status.ok()) return status;
  if (const auto status = CheckTriangles(instances, path, limits); !status.ok()) return status;
  const size_t most = request.max_receivers > 0 ? request.max_receivers : limits.max_receivers + 1;
  const auto found = FindPlanarSurfaces(instances, request.min_area_m2, most);
  if (found.size() > limits.max_receivers) {
    return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_RECEIVERS", path,
                      absl::StrCat("found more than ", limits.max_receivers,
                                   " surfaces, need fewer: ask for a larger min_area_m2, or set "
                                   "max_receivers"));
  }
  std::vector<Receiver> receivers;
  for (const FoundSurface& surface : found) {
    receivers.push_back({.id = SurfaceReceiverId(request.id_prefix, surface, limits.max_id_bytes),
                         .shape = PlanarSurface{surface.instance_id, surface.triangle},
                         .texels_per_metre = request.texels_per_metre,
                         .max_auto_side = request.max_auto_side});
    if (const auto status = CheckId(receivers.back().id, path + ".id_prefix"); !status.ok()) {
      return status;
    }
  }
  return receivers;
}

}  // namespace penumbra
