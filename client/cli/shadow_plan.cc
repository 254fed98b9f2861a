#include "client/cli/shadow_plan.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/cli/option_error.h"
#include "client/cli/surface_plan.h"
#include "render/scene/field_error.h"
#include "render/scene/unoccluded_light.h"
#include "render/technique/artifact_spec.h"

namespace penumbra {
namespace {

template <typename T>
bool HasId(const std::vector<T>& objects, std::string_view id) {
  return std::ranges::any_of(objects, [id](const T& object) { return object.id == id; });
}

template <typename T>
const T* FindById(const std::vector<T>& objects, std::string_view id) {
  const auto found = std::ranges::find_if(objects, [id](const T& o) { return o.id == id; });
  return found == objects.end() ? nullptr : &*found;
}

template <typename T>
std::string UniqueId(const std::vector<T>& taken, const std::string& wanted) {
  std::string id = wanted;
  for (int number = 2; HasId(taken, id); ++number) id = absl::StrCat(wanted, "-", number);
  return id;
}

template <typename T>
std::vector<std::string> IdsOf(const std::vector<T>& objects) {
  std::vector<std::string> ids;
  for (const T& object : objects) ids.push_back(object.id);
  return ids;
}

absl::Status PlanLights(const ImportedScene& imported, const ShadowRequest& request,
                        ShadowPlan& plan) {
  std::vector<AreaLight>& used = plan.delta.upsert_lights;
  const bool adds_up = std::ranges::count(request.light_ids, kAllLights) > 0;
  if (adds_up && request.light_ids.size() > 1) {
    return OptionError("--light", "CONFLICT", {kAllLights},
                       ", which is all of them, and another --light, need it alone");
  }
  if (adds_up) used = imported.lights;
  for (const std::string& id : request.light_ids) {
    if (id == kAllLights) continue;
    const AreaLight* light = FindById(imported.lights, id);
    if (light == nullptr) return UnknownIdError("--light", id, IdsOf(imported.lights));
    if (!HasId(used, id)) used.push_back(*light);
  }
  for (AreaLight light : request.lights) {
    light.id = UniqueId(used, light.id);
    used.push_back(std::move(light));
  }
  if (used.empty()) used = imported.lights;
  if (used.empty()) {
    used.push_back(LightAbove(Bounds(imported)));
    plan.notes.push_back("the scene has no lights: a rectangle above it shines down");
  }
  plan.light_ids = IdsOf(used);
  if (adds_up && request.adds_up_lights) plan.light_ids = {std::string(kAllLights)};
  return absl::OkStatus();
}

// The server makes the receivers; which, is known here as well.
absl::Status PlanSurfaces(const ImportedScene& imported, const ShadowRequest& request,
                          ShadowPlan& plan) {
  const InstanceTable instances = TableOf(imported);
  PlanarSurfaceRequest every =
      SurfaceRequestFor(instances, request.min_area_m2, request.texels_per_metre);
  const SceneLimits limits;
  const auto receivers = ReceiversOnSurfaces(instances, every, "--every-polygon", limits);
  if (ErrorReason(receivers.status()) == "QUOTA_RECEIVERS") {
    return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_RECEIVERS", "--every-polygon",
                      absl::StrCat("found more than ", limits.max_receivers,
                                   " planar surfaces, need fewer: ask for a larger --min-area"));
  }
  if (!receivers.ok()) return receivers.status();
  if (receivers->empty()) {
    return absl::NotFoundError(absl::StrCat("--every-polygon: found no planar surface of ",
                                            request.min_area_m2, " m2 or more, need one"));
  }
  for (const Receiver& receiver : *receivers) plan.receiver_ids.push_back(receiver.id);
  plan.delta.receive_on_planar_surfaces = std::move(every);
  return absl::OkStatus();
}

absl::Status PlanReceivers(const ImportedScene& imported, const ShadowRequest& request,
                           ShadowPlan& plan) {
  std::vector<Receiver>& used = plan.delta.upsert_receivers;
  const GridSize texels = request.texels.value_or(GridSize{});
  const auto add = [&](const std::string& id, auto shape, bool two_sided) {
    used.push_back({.id = UniqueId(used, id),
                    .shape = std::move(shape),
                    .width = texels.width,
                    .height = texels.height,
                    .two_sided = two_sided,
                    .reflectance = request.reflectance});
  };
  if (request.floor) add("floor", FloorUnder(Bounds(imported)), false);
  for (const Parallelogram& patch : request.receivers) add("receiver", patch, true);
  for (const std::string& id : request.receiver_instances) {
    const Instance* instance = FindById(imported.instances, id);
    if (instance == nullptr) {
      return UnknownIdError("--receiver-instance", id, IdsOf(imported.instances));
    }
    if (const auto patch = BoundingParallelogram(*instance); !patch.ok()) {
      return OfOption("--receiver-instance", patch.status());
    }
    add(id, PlanarInstance{id}, true);
  }
  for (const Receiver& receiver : used) plan.receiver_ids.push_back(receiver.id);
  return request.every_polygon ? PlanSurfaces(imported, request, plan) : absl::OkStatus();
}

// The patch as a thing that casts and is seen.
absl::StatusOr<Instance> InstanceOn(const Parallelogram& patch, Vec3 color, std::string id) {
  MeshGeometry square;
  for (const Vec2 uv : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)}) {
    square.positions.push_back(patch.At(uv));
    square.uvs.push_back(uv);
  }
  square.indices = {0, 1, 2, 0, 2, 3};
  auto mesh = Mesh::Create(std::move(square));
  if (!mesh.ok()) return mesh.status();
  return Instance{.id = std::move(id), .mesh = *std::move(mesh), .color = color};
}

absl::Status PlanSurfacesAtOnce(const ImportedScene& imported, const ShadowRequest& request,
                                ShadowPlan& plan) {
  if (request.floor) {
    std::vector<Instance>& instances = plan.delta.upsert_instances;
    auto floor =
        InstanceOn(FloorUnder(Bounds(imported)), request.reflectance, UniqueId(instances, "floor"));
    if (!floor.ok()) return floor.status();
    instances.push_back(*std::move(floor));
  }
  return absl::OkStatus();
}

std::string NameOf(const std::string& what, const std::string& light_id, bool has_several_lights) {
  if (what.empty()) return light_id;
  return has_several_lights ? absl::StrCat(what, ".", light_id) : what;
}

}  // namespace

std::vector<PlannedShadow> ShadowsOf(const ShadowPlan& plan, const TechniqueParams& params) {
  std::vector<PlannedShadow> shadows;
  const bool has_several = plan.light_ids.size() > 1;
  const auto add = [&](const std::string& what, const std::string& receiver_id,
                       const std::optional<PointReceiver>& points) {
    for (const std::string& light_id : plan.light_ids) {
      shadows.push_back({.spec = {.params = params,
                                  .light_id = light_id,
                                  .receiver_id = receiver_id,
                                  .points = points},
                         .name = NameOf(what, light_id, has_several)});
    }
  };
  switch (InfoOf(params).target) {
    case SpecTarget::kReceiver:
      for (const std::string& id : plan.receiver_ids) add(id, id, std::nullopt);
      break;
    case SpecTarget::kScene:
      add("", "", std::nullopt);
      break;
    case SpecTarget::kPoints:
      for (const PlannedPoints& points : plan.points) add(points.name, "", points.receiver);
      break;
  }
  return shadows;
}

absl::StatusOr<ShadowPlan> PlanShadows(const ImportedScene& imported,
                                       const ShadowRequest& request) {
  ShadowPlan plan;
  plan.notes = imported.warnings;
  plan.delta.upsert_instances = imported.instances;
  if (absl::Status status = PlanLights(imported, request, plan); !status.ok()) return status;
  const SpecTarget target = InfoOf(request.params).target;
  absl::Status status = target == SpecTarget::kReceiver
                            ? PlanReceivers(imported, request, plan)
                            : PlanSurfacesAtOnce(imported, request, plan);
  if (!status.ok()) return status;
  if (target == SpecTarget::kPoints) {
    auto points = PlanPoints(imported, request);
    if (!points.ok()) return points.status();
    plan.points = *std::move(points);
  }
  return plan;
}

Parallelogram FloorUnder(const Aabb& bounds) {
  if (bounds.empty()) return FloorUnder({.min = Vec3(-0.5f, 0, -0.5f), .max = Vec3(0.5f, 0, 0.5f)});
  const Vec3 extent = bounds.extent();
  const float larger = std::max(extent.x, extent.z);
  const float fallback = larger > 0.0f ? larger : 1.0f;
  const float width = 3.0f * (extent.x > 0.0f ? extent.x : fallback);
  const float depth = 3.0f * (extent.z > 0.0f ? extent.z : fallback);
  const Vec3 center = bounds.center();
  return {.origin = {center.x - 0.5f * width, bounds.min.y, center.z + 0.5f * depth},
          .edge_u = {width, 0, 0},
          .edge_v = {0, 0, -depth}};
}

AreaLight LightAbove(const Aabb& bounds) {
  const Aabb box = bounds.empty() ? Aabb{.min = Vec3(-0.5f), .max = Vec3(0.5f)} : bounds;
  const Vec3 extent = box.extent();
  const float width = std::max({extent.x, extent.z, 0.5f * extent.y, 1e-3f});
  // As far above the top as the scene is wide, and half as wide: tops are not much brighter than
  // the floor then, and penumbrae are wide enough to see.
  const float side = 0.5f * width;
  const Vec3 middle(box.center().x, box.max.y + width, box.center().z);
  RectangleLight light{.corner = middle - Vec3(0.5f * side, 0, 0.5f * side),
                       .edge_u = {side, 0, 0},
                       .edge_v = {0, 0, side}};
  const Vec3 below(middle.x, box.min.y, middle.z);
  const float reflected = UnoccludedRadiance({"above", light}, below, Vec3(0, 1, 0)).x;
  if (reflected > 0.0f) light.radiance = Vec3(1.0f / reflected);
  return {.id = "above", .shape = light};
}

std::vector<std::string> LargestPlanarInstances(const ImportedScene& imported, size_t count) {
  std::vector<std::pair<float, std::string>> found;
  for (const Instance& instance : imported.instances) {
    if (!instance.receives || instance.mesh == nullptr) continue;
    const auto patch = BoundingParallelogram(instance);
    if (!patch.ok()) continue;
    found.emplace_back(glm::length(glm::cross(patch->edge_u, patch->edge_v)), instance.id);
  }
  std::ranges::stable_sort(found, std::greater<>(), &std::pair<float, std::string>::first);
  if (found.size() > count) found.resize(count);
  std::vector<std::string> ids;
  for (auto& [area, id] : found) ids.push_back(std::move(id));
  return ids;
}

}  // namespace penumbra
