#include "tests/fuzz/targets/scene_rules.h"

#include <cmath>

#include "render/scene/scene_hash.h"
#include "tests/fuzz/kit/require.h"

namespace penumbra::fuzzing {
namespace {

bool IsWithin(Vec3 v, float most) {
  for (int c = 0; c < 3; ++c) {
    if (!(std::abs(v[c]) <= most)) return false;
  }
  return true;
}

void RequireInstances(const Scene& scene, const SceneLimits& limits) {
  uint64_t triangles = 0;
  for (const auto& [id, instance] : scene.instances()) {
    Require(CheckId(id, "id").ok() && id == instance->id, "ids are ids");
    for (int column = 0; column < 4; ++column) {
      Require(IsWithin(instance->world_from_mesh[column], limits.max_coordinate),
              "maps are of numbers within the limits");
    }
    triangles += instance->mesh->triangle_count();
  }
  Require(triangles <= limits.max_triangles_per_scene, "triangles keep to their limit");
}

void RequireReceivers(const Scene& scene, const SceneLimits& limits) {
  for (const auto& [id, receiver] : scene.receivers()) {
    const auto patch = scene.ResolveReceiver(id);
    Require(patch.ok(), "a receiver has a place: " + patch.status().ToString());
    Require(patch->width > 0 && patch->height > 0 && patch->width <= limits.max_receiver_side &&
                patch->height <= limits.max_receiver_side,
            "a receiver has texels, and not too many");
    Require(IsFinite(patch->patch.origin) && IsFinite(patch->patch.normal()),
            "a receiver's place is of numbers");
  }
}

}  // namespace

ContentHash HashAnew(const Scene& scene) {
  ContentHash hash;
  for (const auto& [id, instance] : scene.instances()) hash = Combine(hash, HashOf(*instance));
  for (const auto& [id, light] : scene.lights()) hash = Combine(hash, HashOf(*light));
  for (const auto& [id, receiver] : scene.receivers()) hash = Combine(hash, HashOf(*receiver));
  return hash;
}

void RequireRules(const Scene& scene, const SceneLimits& limits) {
  Require(HashAnew(scene) == scene.content_hash(), "the hash is that of the content");
  Require(scene.instances().size() <= limits.max_instances &&
              scene.lights().size() <= limits.max_lights &&
              scene.receivers().size() <= limits.max_receivers,
          "a scene keeps to its limits");
  RequireInstances(scene, limits);
  RequireReceivers(scene, limits);
  scene.casters();
  scene.Bounds();
}

}  // namespace penumbra::fuzzing
