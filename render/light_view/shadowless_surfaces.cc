#include "render/light_view/shadowless_surfaces.h"

#include <string>
#include <utility>

namespace penumbra {
namespace {

std::shared_ptr<const Mesh> MeshOf(const Parallelogram& patch) {
  MeshGeometry square{.indices = {0, 1, 2, 0, 2, 3}};
  for (const Vec2 uv : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)}) {
    square.positions.push_back(patch.At(uv));
  }
  auto mesh = Mesh::Create(std::move(square));
  return mesh.ok() ? *std::move(mesh) : nullptr;
}

// The next of surface-0, surface-1, … that no instance has.
std::string FreeId(const Scene& scene, size_t& next) {
  for (;;) {
    std::string id = "surface-" + std::to_string(next++);
    if (scene.FindInstance(id) == nullptr) return id;
  }
}

// Of receivers that stand by themselves.
std::vector<Instance> Patches(const Scene& scene) {
  std::vector<Instance> patches;
  size_t next_id = 0;
  for (const auto& [id, receiver] : scene.receivers()) {
    if (InstanceOf(*receiver) != nullptr) continue;
    const auto patch = scene.ResolveReceiver(id);
    if (!patch.ok()) continue;
    if (auto mesh = MeshOf(patch->patch)) {
      patches.push_back({.id = FreeId(scene, next_id), .mesh = std::move(mesh)});
    }
  }
  return patches;
}

// What receives and does not cast; here it does.
std::vector<Instance> InstancesWithoutShadows(const Scene& scene) {
  std::vector<Instance> surfaces;
  for (const auto& [id, instance] : scene.instances()) {
    if (instance->casts || !instance->receives || instance->mesh->triangle_count() == 0) continue;
    surfaces.push_back(*instance);
    surfaces.back().casts = true;
  }
  for (Instance& patch : Patches(scene)) surfaces.push_back(std::move(patch));
  return surfaces;
}

}  // namespace

std::vector<std::shared_ptr<const Scene>> SurfacesWithoutShadows(const Scene& scene) {
  std::vector<std::shared_ptr<const Scene>> surfaces;
  for (Instance& instance : InstancesWithoutShadows(scene)) {
    const auto alone = Scene::Empty(scene.id())->Apply({.upsert_instances = {std::move(instance)}});
    if (alone.ok()) surfaces.push_back(*alone);
  }
  return surfaces;
}

absl::StatusOr<std::shared_ptr<const Scene>> WithAllSurfaces(const Scene& scene) {
  SceneDelta delta;
  delta.upsert_instances = Patches(scene);
  return scene.Apply(delta);
}

}  // namespace penumbra
