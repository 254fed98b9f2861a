#include "render/technique/layered_attenuation/shadowless_surfaces.h"

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

}  // namespace

std::vector<std::shared_ptr<const Scene>> SurfacesWithoutShadows(const Scene& scene) {
  std::vector<std::shared_ptr<const Scene>> surfaces;
  const auto add = [&](Instance instance) {
    instance.id = "surface";
    instance.casts = true;
    const auto alone = Scene::Empty(scene.id())->Apply({.upsert_instances = {std::move(instance)}});
    if (alone.ok()) surfaces.push_back(*alone);
  };
  for (const auto& [id, instance] : scene.instances()) {
    if (!instance->casts && instance->receives && instance->mesh->triangle_count() > 0) {
      add(*instance);
    }
  }
  for (const auto& [id, receiver] : scene.receivers()) {
    if (InstanceOf(*receiver) != nullptr) continue;
    const auto patch = scene.ResolveReceiver(id);
    if (!patch.ok()) continue;
    if (auto mesh = MeshOf(patch->patch)) add({.mesh = std::move(mesh)});
  }
  return surfaces;
}

}  // namespace penumbra
