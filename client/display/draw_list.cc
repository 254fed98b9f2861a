#include "client/display/draw_list.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <variant>

#include "client/display/polygon_mesh.h"
#include "client/display/surface_glsl.h"
#include "client/display/unit_shapes.h"
#include "render/math/basis.h"

namespace penumbra {
namespace {

// Share of its distance by which a free-standing receiver steps back, and a light forward, so that
// surfaces at the same place do not fight: far above the rounding of depth, which a face that
// reaches up to the eye brings to some 1e-5, and far below what can be seen.
constexpr float kDepthStep = 2e-4f;

Affine PatchAffine(Vec3 origin, Vec3 u, Vec3 v) {
  const DVec3 n = glm::cross(DVec3(u), DVec3(v));
  return Affine(u, v, Vec3(glm::normalize(n)), origin);
}

// Takes +z to `axis`, a mesh of radius 1 to `radius`.
Affine RoundAffine(Vec3 center, Vec3 axis, float radius) {
  const auto [s, t, n] = BasisAround(DVec3(axis));
  return Affine(radius * Vec3(s), radius * Vec3(t), radius * Vec3(n), center);
}

DrawItem Glow(std::shared_ptr<const Mesh> mesh, const Affine& place, Vec3 radiance,
              bool two_sided) {
  return {.mesh = std::move(mesh),
          .world_from_mesh = place,
          .depth_scale = 1.0f + kDepthStep,
          .glows = true,
          .color = radiance,
          .two_sided = two_sided};
}

struct GlowOf {
  std::vector<DrawItem>& items;

  void operator()(const RectangleLight& light) const {
    items.push_back(Glow(UnitSquare(), PatchAffine(light.corner, light.edge_u, light.edge_v),
                         light.radiance, light.two_sided));
  }
  void operator()(const DiskLight& light) const {
    items.push_back(Glow(UnitDisk(), RoundAffine(light.center, light.normal, light.radius),
                         light.radiance, light.two_sided));
  }
  void operator()(const SphereLight& light) const {
    items.push_back(Glow(UnitSphere(), RoundAffine(light.center, Vec3(0, 0, 1), light.radius),
                         light.radiance, true));
  }
  template <typename Shape>
  void operator()(const Shape&) const {}  // points and the sky have no shape
};

bool Overlap(const Aabb& a, const Aabb& b) {
  return !a.empty() && !b.empty() && a.min.x <= b.max.x && b.min.x <= a.max.x &&
         a.min.y <= b.max.y && b.min.y <= a.max.y && a.min.z <= b.max.z && b.min.z <= a.max.z;
}

Aabb BoundsOf(const Parallelogram& patch, float margin) {
  Aabb box;
  for (const Vec2 uv : {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1), Vec2(1, 1)}) box.Add(patch.At(uv));
  box.min -= Vec3(margin);
  box.max += Vec3(margin);
  return box;
}

// Whether `box` reaches the receiver's plane.
bool ReachesPlane(const Aabb& box, const GpuReceiver& receiver) {
  const Vec3 n(receiver.normal);
  const float reach = 0.5f * glm::dot(box.extent(), glm::abs(n)) + receiver.origin.w;
  return std::abs(glm::dot(n, box.center() - Vec3(receiver.origin))) <= reach;
}

// Whether `instance` fills just the patch, so that the patch need not be drawn.
bool Coincides(const Instance& instance, const Aabb& bounds, const Parallelogram& patch) {
  const float extent = std::max(glm::length(patch.edge_u), glm::length(patch.edge_v));
  const float tolerance = 1e-3f * extent;
  const Aabb box = BoundsOf(patch, 0);
  const auto is_near = [&](Vec3 a, Vec3 b) { return glm::length(a - b) <= 2 * tolerance; };
  if (!is_near(box.min, bounds.min) || !is_near(box.max, bounds.max)) return false;
  const auto placed = BoundingParallelogram(instance);
  if (!placed.ok()) return false;
  for (const Vec2 uv : {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1), Vec2(1, 1)}) {
    const Vec3 corner = placed->At(uv);
    if (!is_near(corner, patch.At({0, 0})) && !is_near(corner, patch.At({1, 0})) &&
        !is_near(corner, patch.At({0, 1})) && !is_near(corner, patch.At({1, 1}))) {
      return false;
    }
  }
  return true;
}

class Builder {
 public:
  Builder(const Scene& scene, std::span<const std::shared_ptr<const Artifact>> artifacts)
      : scene_(scene) {
    std::map<std::string, uint32_t, std::less<>> light_index;
    for (const auto& [id, light] : scene.lights()) {
      light_index[id] = static_cast<uint32_t>(list_.lights.size());
      list_.lights.push_back(ToGpu(*light));
    }
    for (const auto& artifact : artifacts) {
      if (artifact == nullptr) continue;
      const auto* texture = std::get_if<SoftShadowTexture>(&artifact->payload);
      const auto light = light_index.find(artifact->header.light_id);
      if (light == light_index.end()) continue;
      if (texture == nullptr) list_.of_any_surface.emplace_back(light->second, artifact);
      const auto receiver = scene.FindReceiver(artifact->header.receiver_id);
      if (texture != nullptr && receiver != nullptr) {
        AddArtifact(artifact, *texture, light->second, *receiver);
      }
    }
  }

  DrawList Build(bool draws_lights) {
    for (const auto& [id, instance] : scene_.instances()) AddInstance(*instance);
    float step_back = 1.0f;
    for (const auto& [id, receiver] : scene_.receivers()) {
      const float depth_scale = 1.0f - step_back * kDepthStep;
      if (std::visit([&](const auto& shape) { return AddShape(*receiver, shape, depth_scale); },
                     receiver->shape)) {
        step_back += 0.25f;
      }
    }
    if (draws_lights) {
      for (const auto& [id, light] : scene_.lights()) {
        const size_t first = list_.items.size();
        std::visit(GlowOf{list_.items}, light->shape);
        for (size_t i = first; i < list_.items.size(); ++i) {
          list_.items[i].bounds =
              TransformBounds(list_.items[i].world_from_mesh, list_.items[i].mesh->bounds());
        }
      }
    }
    return std::move(list_);
  }

 private:
  struct Place {
    uint32_t light;
    std::string receiver_id;
    std::string instance_id;  // empty where the receiver is not all of an instance
    std::string part_of;      // the instance that it is a part of
    Aabb bounds;
  };

  void AddArtifact(const std::shared_ptr<const Artifact>& artifact,
                   const SoftShadowTexture& texture, uint32_t light, const Receiver& receiver) {
    const VisibilityMap& map = texture.visibility;
    const size_t texels = size_t{map.width} * map.height;
    if (texels == 0 || map.counts.size() != texels) return;
    list_.receivers.push_back(ToGpu(texture, static_cast<uint32_t>(list_.texel_count)));
    list_.artifacts.push_back(artifact);
    list_.texel_count += PlacesOf(texture);
    const auto* planar = std::get_if<PlanarInstance>(&receiver.shape);
    const auto* part = std::get_if<PlanarSurface>(&receiver.shape);
    places_.push_back(
        {.light = light,
         .receiver_id = receiver.id,
         .instance_id = planar != nullptr ? planar->instance_id : std::string(),
         .part_of = part != nullptr ? part->instance_id : std::string(),
         .bounds = BoundsOf(texture.receiver.patch, list_.receivers.back().origin.w)});
  }

  // The artifacts that may lie on what is inside `bounds`, a light's own receiver before the
  // others.
  void AddCandidates(DrawItem& item, std::string_view instance_id, std::string_view receiver_id) {
    std::vector<Candidate> found;
    for (uint32_t i = 0; i < places_.size(); ++i) {
      const Place& place = places_[i];
      const bool is_own =
          instance_id.empty() ? place.receiver_id == receiver_id : place.instance_id == instance_id;
      if (is_own) {
        found.push_back({.light = place.light, .receiver = i | kIsTheReceiver});
      } else if (Overlap(item.bounds, place.bounds) &&
                 ReachesPlane(item.bounds, list_.receivers[i])) {
        const bool is_part = !instance_id.empty() && place.part_of == instance_id;
        found.push_back({.light = place.light, .receiver = is_part ? i | kIsPartOfIt : i});
      }
    }
    std::stable_sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) {
      if (a.light != b.light) return a.light < b.light;
      return (a.receiver & kIsTheReceiver) > (b.receiver & kIsTheReceiver);
    });
    item.first_candidate = static_cast<uint32_t>(list_.candidates.size());
    list_.candidates.insert(list_.candidates.end(), found.begin(), found.end());
    item.end_candidate = static_cast<uint32_t>(list_.candidates.size());
  }

  void AddInstance(const Instance& instance) {
    DrawItem item = {.mesh = instance.mesh,
                     .world_from_mesh = instance.world_from_mesh,
                     .bounds = WorldBounds(instance),
                     .color = instance.color,
                     .alpha_mask = instance.alpha_mask,
                     .alpha_cutoff = instance.alpha_cutoff,
                     .receives = instance.receives};
    if (item.bounds.empty()) return;
    if (instance.receives) AddCandidates(item, instance.id, {});
    list_.items.push_back(std::move(item));
  }

  // A receiver that stands by itself is drawn; what lies on an instance is that instance.
  bool AddShape(const Receiver&, const PlanarInstance&, float) { return false; }
  bool AddShape(const Receiver&, const PlanarSurface&, float) { return false; }
  bool AddShape(const Receiver& receiver, const Triangle& triangle, float depth_scale) {
    const Vec3 a = triangle.corner;
    const Vec3 corners[] = {a, a + triangle.edge_u, a + triangle.edge_v};
    return AddOutline(receiver, corners, depth_scale);
  }
  bool AddShape(const Receiver& receiver, const PlanarPolygon& polygon, float depth_scale) {
    return AddOutline(receiver, polygon.vertices, depth_scale);
  }
  bool AddOutline(const Receiver& receiver, std::span<const Vec3> outline, float depth_scale) {
    DrawItem item = {
        .mesh = MeshOfPolygon(outline), .depth_scale = depth_scale, .color = receiver.reflectance};
    if (item.mesh == nullptr) return false;
    item.bounds = item.mesh->bounds();
    AddCandidates(item, {}, receiver.id);
    list_.items.push_back(std::move(item));
    return true;
  }
  bool AddShape(const Receiver& receiver, const Parallelogram& patch, float depth_scale) {
    for (const auto& [id, instance] : scene_.instances()) {
      if (Coincides(*instance, WorldBounds(*instance), patch)) return false;
    }
    DrawItem item = {.mesh = UnitSquare(),
                     .world_from_mesh = PatchAffine(patch.origin, patch.edge_u, patch.edge_v),
                     .bounds = BoundsOf(patch, 0),
                     .depth_scale = depth_scale,
                     .color = receiver.reflectance};
    AddCandidates(item, {}, receiver.id);
    list_.items.push_back(std::move(item));
    return true;
  }

  const Scene& scene_;
  DrawList list_;
  std::vector<Place> places_;  // one an artifact
};

}  // namespace

DrawList BuildDrawList(const Scene& scene,
                       std::span<const std::shared_ptr<const Artifact>> artifacts,
                       bool draws_lights) {
  return Builder(scene, artifacts).Build(draws_lights);
}

}  // namespace penumbra
